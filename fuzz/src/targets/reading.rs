//! READ of any bytes with any types and widths, text and binary: how the bytes are cut into pieces changes nothing.

use std::fmt::Write as _;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

use karel_emulator::effects::{ConnectionId, Event, Tag};
use karel_emulator::{Controller, ProgramSource, ScreenSink};

use super::core::{check_bounds, config, ms};
use crate::choices::Choices;

const ITEMS: &[&str] = &["i", "r", "b", "t", "u", "CR", "y", "h"];

/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    let mut choices = Choices::new(data);
    let source = program(&mut choices);
    let cuts: Vec<usize> = (0..4).map(|_| usize::from(choices.byte())).collect();
    let bytes = choices.rest();
    let whole = outcome(&source, &[bytes]);
    let single: Vec<&[u8]> = bytes.chunks(1).collect();
    assert_eq!(whole, outcome(&source, &single), "byte by byte\n{source}");
    let mut rest = bytes;
    let mut pieces = Vec::new();
    for cut in cuts {
        let (piece, behind) = rest.split_at(cut.min(rest.len()));
        pieces.push(piece);
        rest = behind;
    }
    pieces.push(rest);
    assert_eq!(whole, outcome(&source, &pieces), "in pieces\n{source}");
}

/// Reads what it is told to, again and again until the peer is gone, and shows everything.
fn program(choices: &mut Choices<'_>) -> String {
    let mut setting = String::new();
    if choices.below(3) == 0 {
        setting.push_str("  SET_FILE_ATR(f, ATR_UF)\n");
        if choices.below(2) == 1 {
            setting.push_str("  SET_FILE_ATR(f, ATR_REVERSE)\n");
        }
    } else if choices.below(4) == 1 {
        let end = choices.byte();
        setting = format!("  SET_FILE_ATR(f, ATR_EOL, {end})\n");
    }
    let mut body = String::new();
    for _ in 0..=choices.below(4) {
        let items: Vec<String> = (0..=choices.below(4)).map(|_| item(choices)).collect();
        let _written = writeln!(body, "    READ f({})\n    show", items.join(", "));
    }
    format!(
        "PROGRAM reads
VAR
  f : FILE
  s, i, rounds : INTEGER
  r : REAL
  b : BOOLEAN
  t : STRING[6]
  u : STRING[200]
  y : ARRAY[1] OF BYTE
  h : ARRAY[1] OF SHORT
ROUTINE show
BEGIN
  WRITE (IO_STATUS(f))
  IF NOT UNINIT(i) THEN ; WRITE (' i', i) ; ENDIF
  IF NOT UNINIT(r) THEN ; WRITE (' r', r) ; ENDIF
  IF NOT UNINIT(b) THEN ; WRITE (' b', b) ; ENDIF
  IF NOT UNINIT(t) THEN ; WRITE (' t[', t, ']') ; ENDIF
  IF NOT UNINIT(u) THEN ; WRITE (' u[', u, ']') ; ENDIF
  IF NOT UNINIT(y[1]) THEN ; WRITE (' y', y[1]) ; ENDIF
  IF NOT UNINIT(h[1]) THEN ; WRITE (' h', h[1]) ; ENDIF
  WRITE (CR)
END show
BEGIN
{setting}  MSG_CONNECT('S3:', s)
  OPEN FILE f('RW', 'S3:')
  FOR rounds = 1 TO 20 DO
{body}  ENDFOR
  CLOSE FILE f
END reads
"
    )
}

fn item(choices: &mut Choices<'_>) -> String {
    let name = *choices.one_of(ITEMS);
    let name = match name {
        "y" | "h" => format!("{name}[1]"),
        other => other.to_owned(),
    };
    match choices.below(5) {
        // The end of a line has no width.
        _ if name == "CR" => name,
        // `::0` asks what is there now, so it depends on the pieces by its nature.
        1 => format!("{name}::{}", 1 + choices.below(12)),
        2 => format!("{name}::{}", choices.short().max(1)),
        _ => name,
    }
}

/// What the program showed, and how it stands, when its peer has sent these pieces and has closed.
fn outcome(source: &str, pieces: &[&[u8]]) -> String {
    let shown = Arc::new(Mutex::new(Vec::new()));
    let sink = shown.clone();
    let mut config = config().with_program(ProgramSource::new("reads.kl", source));
    config.limits.instructions_per_ms = 100_000;
    config.screen = Some(ScreenSink(Arc::new(move |bytes: &[u8]| {
        sink.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .extend_from_slice(bytes);
    })));
    let mut core = Controller::try_new(&config)
        .unwrap_or_else(|error| panic!("a correct program is refused: {error}\n{source}"));
    core.advance_fully(ms(1));
    let connection = ConnectionId(1);
    core.event(Event::Connected {
        tag: Tag::try_new(3).expect("S3 is a tag"),
        connection,
        peer: SocketAddr::from(([127, 0, 0, 1], 4000)),
    });
    core.advance_fully(ms(2));
    for piece in pieces {
        let mut piece = *piece;
        while !piece.is_empty() {
            let room = core.room(connection).min(piece.len());
            if room == 0 {
                break;
            }
            let (bytes, behind) = piece.split_at(room);
            core.event(Event::Bytes {
                connection,
                bytes: bytes.to_vec(),
                request_id: None,
            });
            core.advance_fully(ms(2));
            piece = behind;
        }
    }
    core.event(Event::PeerClosed { connection });
    core.advance_fully(ms(100));
    check_bounds(&core);
    let task = core.state().tasks.first().map(|task| format!("{task:?}"));
    let shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
    format!("{}\n{task:?}", shown.escape_ascii())
}
