//! Jobs while the disk is full.

use journal::MemoryDisk;
use workflow::SignalKind;

use super::World;
use crate::cell::handle::Refused;
use crate::journal::Trouble;

/// Covers: D1. On the reserve what a job does goes on being kept, and no job is begun; with room again one is.
#[tokio::test]
async fn d1_on_the_reserve_a_job_goes_on_and_none_begins() {
    let disk = MemoryDisk::new();
    let mut world = World::on(&disk).await;
    let _job = world.pickup().await;
    let order = world.message("TRANSPORT_ORDER").await;
    disk.fill();
    let before = disk.rows().len();
    world.says(SignalKind::MrAssigned, order.session).await;
    let _permit = world.message("MOVE_PERMIT").await;
    assert!(disk.rows().len() > before);
    let refused = world.ask_for_pickup().await;
    assert!(
        matches!(refused, Err(Refused::NotKept(Trouble::NoRoom(_)))),
        "{refused:?}"
    );
    disk.make_room();
    // The second one is refused for another reason: the load is taken already.
    let asked = world.ask_for_pickup().await;
    assert!(!matches!(asked, Err(Refused::NotKept(_))), "{asked:?}");
}
