//! Many controllers in one process.

mod common;

use common::{ACCEPTED, LINE, PORT, call, sock_server, wait_until, within};
use karel_emulator::{Clock, PeerLabels, VirtualController};

#[tokio::test]
async fn a_hundred_controllers_serve_in_one_process() {
    let controllers: Vec<_> = (0..100)
        .map(|_| {
            let clock = Clock::scaled(200.0).unwrap();
            VirtualController::start(&sock_server(), clock, PeerLabels::new()).unwrap()
        })
        .collect();
    for controller in &controllers {
        let address = within(controller.address_of_port(PORT)).await.unwrap();
        assert_eq!(call(address, LINE).await, ACCEPTED);
    }
    for controller in &controllers {
        wait_until(controller, |state| !state.moving && state.ledger_seq == 2).await;
    }
    for controller in controllers {
        within(controller.shutdown()).await;
    }
}
