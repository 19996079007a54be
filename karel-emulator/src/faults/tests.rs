//! Tests of what a fault says.

use super::dice::Dice;
use super::*;

#[test]
fn a_fault_reads_as_the_documents_write_it() {
    let body: FaultBody = serde_json::from_str(
        r#"{"fault": {"delay": {"ms": 200}}, "scope": {"port": 59002, "direction": "in"}, "times": 3}"#,
    )
    .unwrap();
    assert_eq!(
        body.fault,
        FaultKind::Delay {
            ms: 200,
            jitter_ms: 0
        }
    );
    assert_eq!(body.scope.direction, Direction::In);
    assert_eq!(body.check(), Ok(()));
    let body: FaultBody = serde_json::from_str(r#"{"fault": "freeze"}"#).unwrap();
    assert_eq!(body.fault.name(), "freeze");
    for wrong in [
        r#"{"fault": "explode"}"#,
        r#"{"fault": {"delay": {"ms": 1, "s": 2}}}"#,
        r#"{"fault": "drop", "scope": {"prt": 1}}"#,
        r#"{"fault": "drop", "count": 1}"#,
    ] {
        assert!(serde_json::from_str::<FaultBody>(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_item_value_and_limit() {
    let bodies = [
        (
            FaultBody::new(FaultKind::Drop).times(0),
            "times is 0, it must be 1 to 1000000",
        ),
        (FaultBody::new(FaultKind::Stall).for_ms(0), "for_ms is 0"),
        (
            FaultBody::new(FaultKind::Split {
                bytes: 0,
                gap_ms: 1,
            }),
            "split.bytes is 0, it must be 1 to 65536",
        ),
        (
            FaultBody::new(FaultKind::SlowOverride { percent: -3 }),
            "slow_override.percent is -3, it must be 1 to 100",
        ),
        (
            FaultBody::new(FaultKind::WedgeTag { tag: "S9".into() }),
            "S9",
        ),
        (
            FaultBody::new(FaultKind::Freeze).times(2),
            "neither scope nor times",
        ),
        (FaultBody::new(FaultKind::Reset).for_ms(5), "ends by itself"),
    ];
    for (body, words) in bodies {
        let text = body.check().unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn the_same_seed_gives_the_same_numbers_within_the_limit() {
    let draw = |seed| {
        let mut dice = Dice::new(seed);
        (0..50).map(|_| dice.up_to(9)).collect::<Vec<_>>()
    };
    assert_eq!(draw(7), draw(7));
    assert_ne!(draw(7), draw(8));
    assert!(draw(7).iter().all(|n| *n <= 9));
}
