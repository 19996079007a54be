//! The plug pulled at random moments, of a server in this process or of one of its own.

use std::time::Duration;

use crate::chance::Chance;
use crate::kit::TestCell;

/// When the plug is pulled.
pub(crate) struct Moments {
    /// How often in all, at least.
    pub(crate) kills: usize,
    /// How often in each job, the starts that are killed left out.
    pub(crate) crashes_of_a_job: usize,
    /// One start in so many is killed in the middle of its recovery,
    pub(crate) one_start_in: u64,
    /// within so many milliseconds.
    pub(crate) start_ms: u64,
}

/// Runs a delivery and a pickup in one cell after the other, until the plug was pulled often enough. Nothing may happen
/// twice, and each job has to come to an end with a story that fits.
pub(crate) async fn crash_at_random(start: impl AsyncFn() -> TestCell, moments: &Moments) {
    let (mut pulled, mut round) = (0, 0);
    while pulled < moments.kills {
        round += 1;
        let mut chance = Chance(round);
        let mut cell = start().await;
        let jobs = [cell.delivery("rack/d").await, cell.pickup().await];
        for job in &jobs {
            for _ in 0..moments.crashes_of_a_job {
                cell.after(Duration::from_millis(chance.below(300))).await;
                cell.pull_the_plug();
                pulled += 1;
                while chance.below(moments.one_start_in) == 0 {
                    cell.plug_in().await;
                    let moment = Duration::from_millis(chance.below(moments.start_ms));
                    cell.after(moment).await;
                    cell.pull_the_plug();
                    pulled += 1;
                }
                cell.start_server().await;
                cell.assert_nothing_twice().await;
                if cell.is_over(job).await {
                    break;
                }
                let _said = cell.answer_everything().await;
            }
            let (ended, said) = cell.see_through(job).await;
            let story = cell.assert_story(job).await;
            eprintln!(
                "round {round}, {pulled} pulled: {} {story:?} {said:#?}",
                ended["state"]
            );
        }
        cell.assert_sound().await;
    }
    eprintln!("{pulled} plugs pulled in {round} rounds");
}
