//! Whatever a peer sends, the socket server answers once, and the next client is served.

mod common;

use std::net::SocketAddr;
use std::time::Duration;

use common::{ACCEPTED, INCORRECT, UNREACHABLE, sock_server};
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::{Controller, ControllerConfig};
use proptest::prelude::*;

/// Connects, sends the pieces, closes; what the program wrote, once it closed, too.
#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
fn session(core: &mut Controller, number: u64, pieces: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let connection = ConnectionId(number);
    let peer = SocketAddr::from(([127, 0, 0, 1], 40_000));
    let mut effects = Vec::new();
    let mut settle = |core: &mut Controller| {
        let later = core.now() + Duration::from_mins(1);
        core.advance_fully(later);
        effects.extend(core.take_effects());
    };
    settle(core);
    core.event(Event::Connected {
        tag: Tag::try_new(3).unwrap(),
        connection,
        peer,
    });
    settle(core);
    for piece in pieces {
        let bytes = piece.iter().copied().take(core.room(connection)).collect();
        core.event(Event::Bytes {
            connection,
            bytes,
            request_id: None,
        });
        settle(core);
    }
    core.event(Event::PeerClosed { connection });
    settle(core);
    assert!(
        effects.contains(&Effect::Close { connection }),
        "the program closes"
    );
    let mut sent = Vec::new();
    for effect in effects {
        if let Effect::Send {
            connection: to,
            bytes,
        } = effect
            && to == connection
        {
            sent.push(bytes);
        }
    }
    sent
}

fn core_of(config: &ControllerConfig) -> Controller {
    Controller::try_new(config).expect("the socket server is a correct program")
}

fn is_reply(bytes: &[u8]) -> bool {
    [ACCEPTED, INCORRECT, UNREACHABLE]
        .iter()
        .any(|reply| reply.as_bytes() == bytes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bytes_get_one_answer(pieces in prop::collection::vec(
        prop::collection::vec(any::<u8>(), 1..200), 0..6,
    )) {
        let mut core = core_of(&sock_server());
        let sent = session(&mut core, 1, &pieces);
        prop_assert!(sent.len() == 1 && is_reply(&sent[0]), "{sent:?}");
        let good = session(&mut core, 2, &[common::LINE.to_vec()]);
        prop_assert_eq!(good, vec![ACCEPTED.as_bytes().to_vec()]);
    }

    #[test]
    fn almost_commands_get_one_answer_and_only_accepted_ones_move(
        fields in prop::collection::vec(prop_oneof![
            (-2_000_000_i64..2_000_000).prop_map(|n| n.to_string()),
            any::<i64>().prop_map(|n| n.to_string()),
            "[0-9a-z.+-]{0,6}",
        ], 8),
        separator in " {1,3}",
    ) {
        let mut core = core_of(&sock_server());
        let line = fields.join(&separator).into_bytes();
        let sent = session(&mut core, 1, &[line]);
        prop_assert!(sent.len() == 1 && is_reply(&sent[0]), "{sent:?}");
        let moved = !core.ledger(0).is_empty();
        prop_assert_eq!(moved, sent[0] == ACCEPTED.as_bytes());
    }
}
