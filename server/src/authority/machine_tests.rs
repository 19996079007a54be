//! The machine against a reference that fits on a page, under random sequences of everything that can happen.

use std::time::Duration;

use api::{ControlEnd, ControlToken, LossBehavior, Station};
use proptest::prelude::*;
use uuid::Uuid;

use super::machine::{Authority, Denied, Force, Moment, Terms};

const PEOPLE: [&str; 3] = ["anna", "boris", "carla"];

fn terms(who: usize, station: Station, ttl_s: u64) -> Terms {
    Terms {
        holder: PEOPLE[who].to_owned(),
        station,
        ttl: Duration::from_secs(ttl_s),
        loss: LossBehavior::Stop1,
        reason: "a test".to_owned(),
    }
}

fn token(number: u64) -> ControlToken {
    ControlToken {
        lease: Uuid::from_u128(number.into()),
        epoch: number,
    }
}

fn at(seconds: u64) -> Moment {
    Duration::from_secs(seconds)
}

/// A machine in which `who` took control at 0 s for 10 s, with epoch 1.
fn held_by(who: usize, station: Station) -> Authority {
    let mut machine = Authority::default();
    let granted = machine.acquire(at(0), terms(who, station, 10), Force::ByStation, token(1));
    assert!(granted.unwrap().ended.is_none());
    machine
}

/// O2.
#[test]
fn a_second_remote_is_told_who_has_control_and_until_when() {
    let mut machine = held_by(0, Station::Remote);
    let asked = machine.acquire(
        at(3),
        terms(1, Station::Remote, 10),
        Force::ByStation,
        token(2),
    );
    let Err(Denied::Held(lease)) = asked else {
        panic!("{asked:?}");
    };
    assert_eq!(
        (lease.terms.holder.as_str(), lease.expires),
        ("anna", at(10))
    );
    assert_eq!(machine.check(at(3), token(1), "anna"), Ok(()));
    // Its own holder does not get a second lease either: it may be another terminal of the same person.
    let again = machine.may_acquire(at(3), &terms(0, Station::Remote, 10), Force::ByStation);
    assert!(matches!(again, Err(Denied::Held(_))));
}

#[test]
fn local_takes_from_anybody_and_remote_never_from_local() {
    let mut machine = held_by(0, Station::Remote);
    let granted = machine
        .acquire(
            at(1),
            terms(1, Station::Local, 10),
            Force::ByStation,
            token(2),
        )
        .unwrap();
    let ended = granted.ended.unwrap();
    assert_eq!(ended.end, ControlEnd::Preempted);
    assert_eq!(ended.by.as_deref(), Some("boris"));
    assert_eq!(ended.loss(), Some(LossBehavior::Stop1));
    assert!(matches!(
        machine.check(at(1), token(1), "anna"),
        Err(Denied::Lost(Some(_)))
    ));
    for who in [0, 1] {
        let back = machine.may_acquire(at(1), &terms(who, Station::Remote, 10), Force::ByStation);
        assert!(matches!(back, Err(Denied::Held(_))));
    }
    let panel = machine.may_acquire(at(1), &terms(2, Station::Local, 10), Force::ByStation);
    assert_eq!(panel, Ok(()));
    let admin = machine.may_acquire(at(1), &terms(2, Station::Remote, 10), Force::Admin);
    assert_eq!(admin, Ok(()));
}

/// O4, T5.
#[test]
fn a_heartbeat_at_the_end_or_later_is_too_late() {
    let mut machine = held_by(0, Station::Remote);
    let beaten = machine.heartbeat(at(9), token(1).lease, "anna").unwrap();
    assert_eq!(beaten.expires, at(19));
    let late = machine.heartbeat(at(19), token(1).lease, "anna");
    assert!(matches!(late, Err(Denied::Lost(Some(ended))) if ended.end == ControlEnd::Expired));
    assert!(machine.check(at(19), token(1), "anna").is_err());
    let ended = machine.expire(at(19)).unwrap();
    assert_eq!(
        (ended.end, ended.loss()),
        (ControlEnd::Expired, Some(LossBehavior::Stop1))
    );
    assert_eq!(machine.expire(at(20)), None);
}

/// T3.
#[test]
fn a_machine_that_slept_longer_than_the_lease_has_lost_it() {
    let mut machine = Authority::default();
    let jog = terms(0, Station::Local, 2);
    let _granted = machine
        .acquire(at(0), jog, Force::ByStation, token(1))
        .unwrap();
    assert!(machine.heartbeat(at(1), token(1).lease, "anna").is_ok());
    // Suspended for a minute; the first thing heard afterwards is the heartbeat that waited in the socket.
    assert!(machine.heartbeat(at(61), token(1).lease, "anna").is_err());
    // And a clock that jumps back brings nothing back.
    assert!(machine.check(at(2), token(1), "anna").is_err());
    assert!(machine.is_free(at(2)).is_ok());
}

#[test]
fn a_token_serves_its_holder_only() {
    let mut machine = held_by(0, Station::Remote);
    assert!(matches!(
        machine.check(at(1), token(1), "boris"),
        Err(Denied::Held(_))
    ));
    let lease = token(1).lease;
    assert!(matches!(
        machine.heartbeat(at(1), lease, "boris"),
        Err(Denied::Held(_))
    ));
    assert!(matches!(
        machine.release(at(1), lease, "boris"),
        Err(Denied::Held(_))
    ));
    let forged = ControlToken { lease, epoch: 2 };
    assert!(matches!(
        machine.check(at(1), forged, "anna"),
        Err(Denied::Lost(_))
    ));
    assert_eq!(machine.check(at(1), token(1), "anna"), Ok(()));
}

#[test]
fn control_is_given_back_once_and_then_again_without_effect() {
    let mut machine = held_by(0, Station::Remote);
    let lease = token(1).lease;
    let ended = machine.release(at(1), lease, "anna").unwrap().unwrap();
    assert_eq!((ended.end, ended.loss()), (ControlEnd::Released, None));
    assert_eq!(machine.release(at(2), lease, "anna"), Ok(None));
    let _next = machine
        .acquire(
            at(3),
            terms(1, Station::Remote, 10),
            Force::ByStation,
            token(2),
        )
        .unwrap();
    assert_eq!(machine.release(at(4), lease, "anna"), Ok(None));
    assert_eq!(machine.check(at(4), token(2), "boris"), Ok(()));
}

#[test]
fn an_epoch_given_twice_grants_nothing() {
    let mut machine = held_by(0, Station::Remote);
    let again = machine.acquire(
        at(1),
        terms(1, Station::Local, 10),
        Force::ByStation,
        token(1),
    );
    assert!(matches!(
        again,
        Err(Denied::StaleEpoch {
            given: 1,
            latest: 1
        })
    ));
    assert_eq!(machine.check(at(1), token(1), "anna"), Ok(()));
}

#[derive(Clone, Debug)]
enum Step {
    Wait(u64),
    Acquire {
        who: usize,
        local: bool,
        admin: bool,
        ttl_s: u64,
    },
    /// With the token of an earlier grant, counted from the latest one.
    Heartbeat {
        who: usize,
        back: usize,
    },
    Release {
        who: usize,
        back: usize,
    },
    Transfer {
        who: usize,
        back: usize,
        to: usize,
    },
    Revoke,
    Expire,
}

fn step() -> impl Strategy<Value = Step> {
    let (who, back) = (0..3_usize, 0..3_usize);
    prop_oneof![
        3 => (0..8_u64).prop_map(Step::Wait),
        3 => (who.clone(), any::<bool>(), prop::bool::weighted(0.2), 2..12_u64)
            .prop_map(|(who, local, admin, ttl_s)| Step::Acquire { who, local, admin, ttl_s }),
        3 => (who.clone(), back.clone()).prop_map(|(who, back)| Step::Heartbeat { who, back }),
        1 => (who.clone(), back.clone()).prop_map(|(who, back)| Step::Release { who, back }),
        1 => (who.clone(), back, who).prop_map(|(who, back, to)| Step::Transfer { who, back, to }),
        1 => Just(Step::Revoke),
        1 => Just(Step::Expire),
    ]
}

/// Who has control, said as plainly as possible: a number, a person, a time span, an end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reference {
    epoch: u64,
    who: usize,
    ttl_s: u64,
    until: u64,
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    /// SM-3, O2, O4, T3: at every moment exactly the one whom the reference names may act, with the latest token.
    #[test]
    fn one_party_at_most_has_control_and_it_is_the_right_one(
        steps in prop::collection::vec(step(), 1..60),
    ) {
        let mut machine = Authority::default();
        let mut reference: Option<Reference> = None;
        let (mut now, mut latest, mut losses, mut expected_losses) = (0_u64, 0_u64, 0_u32, 0_u32);
        for step in steps {
            if let Step::Wait(seconds) = step {
                now += seconds;
            }
            let before = reference;
            reference = reference.filter(|held| now < held.until);
            let expired = before.is_some() && reference.is_none();
            let present = |back: usize| {
                let number = latest.saturating_sub(back as u64);
                (token(number), reference.filter(|held| held.epoch == number))
            };
            match step {
                Step::Wait(_) | Step::Expire => {}
                Step::Acquire { who, local, admin, ttl_s } => {
                    let station = if local { Station::Local } else { Station::Remote };
                    let force = if admin { Force::Admin } else { Force::ByStation };
                    let granted = machine.acquire(at(now), terms(who, station, ttl_s), force, token(latest + 1));
                    let may = reference.is_none() || local || admin;
                    prop_assert_eq!(granted.is_ok(), may);
                    if let Ok(granted) = granted {
                        latest += 1;
                        losses += u32::from(granted.ended.as_ref().and_then(super::machine::Ended::loss).is_some());
                        expected_losses += u32::from(reference.is_some() || expired);
                        reference = Some(Reference { epoch: latest, who, ttl_s, until: now + ttl_s });
                        continue;
                    }
                }
                Step::Heartbeat { who, back } => {
                    let (token, held) = present(back);
                    let beaten = machine.heartbeat(at(now), token.lease, PEOPLE[who]);
                    let may = held.is_some_and(|held| held.who == who);
                    prop_assert_eq!(beaten.is_ok(), may);
                    if may {
                        reference = reference.map(|held| Reference { until: now + held.ttl_s, ..held });
                    }
                }
                Step::Release { who, back } => {
                    let (token, held) = present(back);
                    let released = machine.release(at(now), token.lease, PEOPLE[who]);
                    match held {
                        Some(held) if held.who == who => {
                            prop_assert!(matches!(released, Ok(Some(_))));
                            reference = None;
                        }
                        Some(_) => prop_assert!(released.is_err()),
                        None => prop_assert_eq!(released, Ok(None)),
                    }
                }
                Step::Transfer { who, back, to } => {
                    let (old, held) = present(back);
                    let moved = machine.transfer(at(now), old.lease, PEOPLE[who], PEOPLE[to], "", token(latest + 1));
                    let may = held.is_some_and(|held| held.who == who);
                    prop_assert_eq!(moved.is_ok(), may);
                    if may {
                        latest += 1;
                        reference = reference.map(|held| Reference {
                            epoch: latest, who: to, until: now + held.ttl_s, ..held
                        });
                    }
                }
                Step::Revoke => {
                    let ended = machine.revoke(at(now));
                    prop_assert_eq!(ended.is_some(), reference.is_some() || expired);
                    losses += u32::from(ended.is_some());
                    expected_losses += u32::from(reference.is_some() || expired);
                    reference = None;
                    continue;
                }
            }
            let ended = machine.expire(at(now));
            prop_assert_eq!(ended.is_some(), expired);
            losses += u32::from(ended.is_some());
            expected_losses += u32::from(expired);

            prop_assert_eq!(machine.epoch(), latest);
            prop_assert_eq!(machine.is_free(at(now)).is_ok(), reference.is_none());
            for (who, name) in PEOPLE.iter().enumerate() {
                for number in 0..=latest + 1 {
                    let may = reference.is_some_and(|held| held.epoch == number && held.who == who);
                    prop_assert_eq!(machine.check(at(now), token(number), name).is_ok(), may);
                }
            }
        }
        prop_assert_eq!(losses, expected_losses);
    }
}
