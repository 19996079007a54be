//! What one mobile robot is asked to do: bring crates from its gate to an arm, take others from an arm to its gate,
//! again and again.

use serde_json::{Value, json};

use crate::plant::LoadedPlant;
use crate::setup::{self, ARMS, MOBILES, POINTS, SLOTS};

/// What was done.
#[derive(Clone, Debug, Default)]
pub(crate) struct Done {
    pub(crate) jobs: u32,
    pub(crate) brought: u32,
    pub(crate) taken: u32,
    /// Jobs that had to wait in the queue when they were looked at first.
    pub(crate) queued: u32,
    /// Where each crate has to be now: the cell, its id, its place or none where it has left.
    pub(crate) crates: Vec<(usize, String, Option<String>)>,
    /// Every job: the cell and its id.
    pub(crate) all: Vec<(usize, String)>,
}

impl Done {
    pub(crate) fn add(&mut self, other: &Self) {
        self.jobs += other.jobs;
        self.brought += other.brought;
        self.taken += other.taken;
        self.queued += other.queued;
        self.crates.extend_from_slice(&other.crates);
        self.all.extend_from_slice(&other.all);
    }
}

pub(crate) struct Worker {
    plant: LoadedPlant,
    cell: usize,
    mobile: usize,
    chance: u64,
    crates: u32,
    /// The crates in the places of this robot, by arm.
    racks: [Vec<String>; 2],
    done: Done,
}

impl Worker {
    pub(crate) fn new(plant: LoadedPlant, cell: usize, mobile: usize) -> Self {
        let seed = (cell * MOBILES.len() + mobile) as u64;
        Self {
            plant,
            cell,
            mobile,
            chance: seed,
            crates: 0,
            racks: [Vec::new(), Vec::new()],
            done: Done::default(),
        }
    }

    /// A small generator of random numbers (SplitMix64): the same run with the same seed, as far as the jobs go.
    fn below(&mut self, limit: usize) -> usize {
        self.chance = self.chance.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.chance;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        usize::try_from((z ^ (z >> 31)) % limit as u64).unwrap()
    }

    /// Rounds until all mobile robots have lived that long, and the crates' places at the end.
    pub(crate) async fn work_until(mut self, seconds: f64) -> Done {
        while self.plant.now().await < seconds {
            self.round().await;
        }
        for (arm, rack) in self.racks.iter().enumerate() {
            for (slot, load) in rack.iter().enumerate() {
                let place = setup::place(arm, self.mobile, slot);
                self.done
                    .crates
                    .push((self.cell, load.clone(), Some(place)));
            }
        }
        self.done
    }

    /// Crates to the arm whose rack is empty; the pickup of those of the other arm waits in the queue meanwhile.
    async fn round(&mut self) {
        let to = match (self.racks[0].is_empty(), self.racks[1].is_empty()) {
            (true, true) => self.below(ARMS.len()),
            (first, _) => usize::from(!first),
        };
        let from = 1 - to;
        let count = 1 + self.below(SLOTS.len());
        let mut brought = Vec::new();
        self.stands_free().await;
        for slot in &SLOTS[..count] {
            self.crates += 1;
            let load = format!("crate-{}-{}", self.mobile + 1, self.crates);
            let robot = self.plant.mobile_robot(self.cell, self.mobile);
            robot.put(slot, &load).await.unwrap();
            brought.push(load);
        }
        let delivery = self.ask("delivery-and-placement", to, count).await;
        self.done.brought += u32::try_from(count).unwrap();
        let taken = std::mem::take(&mut self.racks[from]);
        let pickup = if taken.is_empty() {
            None
        } else {
            // In the queue behind the delivery, whatever its priority: it needs the same mobile robot.
            self.has_begun(&delivery).await;
            Some(self.ask("pickup-and-delivery", from, taken.len()).await)
        };
        self.is_complete(&delivery).await;
        self.racks[to] = brought;
        if let Some(pickup) = pickup {
            self.is_complete(&pickup).await;
            self.done.taken += u32::try_from(taken.len()).unwrap();
            let gone = taken.into_iter().map(|load| (self.cell, load, None));
            self.done.crates.extend(gone);
        }
    }

    /// The mobile robot has ended its way out, so that somebody can put crates into its slots.
    async fn stands_free(&self) {
        let mut state = self.plant.mobile_robot(self.cell, self.mobile).subscribe();
        let stands = state.wait_for(|state| !state.driving && state.order.is_none());
        drop(stands.await.unwrap());
    }

    async fn ask(&mut self, workflow: &str, arm: usize, count: usize) -> String {
        let point = self.below(POINTS.len());
        let mobile = MOBILES[self.mobile];
        let items: Vec<_> = SLOTS[..count]
            .iter()
            .enumerate()
            .map(|(index, slot)| {
                let place = setup::place(arm, self.mobile, index);
                json!({"type": "crate", "mr_slot": slot, "place": place})
            })
            .collect();
        let mut params = json!({
            "mobile_robot": mobile, "point": format!("handover/{}", POINTS[point]), "items": items,
        });
        if workflow == "pickup-and-delivery" {
            params["destination"] = json!(format!("gates/{mobile}"));
            params["complete_on"] = json!("DELIVERED");
            params["prefetch"] = json!(self.below(2) == 0);
        } else {
            params["early_release"] = json!(self.below(2) == 0);
        }
        let body = json!({"workflow": workflow, "params": params, "priority": self.below(3)});
        let path = format!("/api/v1/cells/{}/jobs", setup::cell_id(self.cell));
        let (status, job) = self.plant.post(&path, &body).await;
        assert!(status < 300, "{status} {job}\nto {body}");
        self.done.jobs += 1;
        self.done.queued += u32::from(job["state"] == "IDLE");
        let id = job["id"].as_str().unwrap().to_owned();
        self.done.all.push((self.cell, id.clone()));
        id
    }

    async fn has_begun(&self, job: &str) {
        let _job = self.job(job, |state| state != "IDLE").await;
    }

    async fn is_complete(&self, job: &str) {
        let job = self
            .job(job, |state| {
                matches!(state, "COMPLETE" | "STOPPED" | "ABORTED")
            })
            .await;
        if job["state"] != "COMPLETE" {
            let cell = setup::cell_id(self.cell);
            let asked = self
                .plant
                .get(&format!("/api/v1/cells/{cell}/interventions"))
                .await;
            panic!("{job:#}\n{asked:#}");
        }
    }

    async fn job(&self, id: &str, is_so: impl Fn(&str) -> bool) -> Value {
        let path = format!("/api/v1/cells/{}/jobs/{id}", setup::cell_id(self.cell));
        self.plant
            .wait(&path, async |plant| {
                let job = plant.get(&path).await;
                is_so(job["state"].as_str()?).then_some(job)
            })
            .await
    }
}
