//! Statements a second in one task, beside the same loops in Lua 5.4.
//!
//! Assignments, IF, rounds of FOR, RETURN and calls are statements; a program's own bounds count them. Lua checks no
//! uninitialized data, no subscripts, no overflow and no fuel, so it is a hard baseline. Both get their source: it is
//! translated within the measured time.

use anyhow::Result;
use mlua::Lua;

use crate::process::thread_time;
use crate::{machine, median};

const ROUNDS: u32 = 1_000_000;

/// A loop in both languages, with the statements of one round.
struct Pair {
    name: &'static str,
    statements: u32,
    karel: &'static str,
    lua: &'static str,
}

const PAIRS: &[Pair] = &[
    Pair {
        name: "integers",
        statements: 6,
        karel: "PROGRAM integers
VAR i, a, b, odd : INTEGER
BEGIN
  a = 0
  odd = 0
  FOR i = 1 TO 1000000 DO
    a = a + i MOD 7
    b = a * 2 - i
    IF (b > 5) AND (a <> 3) THEN
      odd = odd + 1
    ENDIF
    a = a - 3
  ENDFOR
END integers
",
        lua: "i, a, b, odd = 0, 0, 0, 0
for n = 1, 1000000 do
  i = n
  a = a + i % 7
  b = a * 2 - i
  if (b > 5) and (a ~= 3) then
    odd = odd + 1
  end
  a = a - 3
end
",
    },
    Pair {
        name: "mixed: a routine, an array, REALs",
        statements: 6,
        karel: "PROGRAM mixed
VAR
  i : INTEGER
  sum : REAL
  list : ARRAY[10] OF REAL
ROUTINE scale(value : REAL; by : REAL) : REAL
BEGIN
  RETURN (value * by / 3)
END scale
BEGIN
  FOR i = 1 TO 10 DO
    list[i] = i
  ENDFOR
  sum = 0
  FOR i = 1 TO 1000000 DO
    list[i MOD 10 + 1] = scale(list[i MOD 10 + 1], 2.5)
    sum = sum + list[3] / 1000
    list[3] = 1
  ENDFOR
END mixed
",
        lua: "i, sum = 0, 0.0
list = {}
function scale(value, by)
  return value * by / 3
end
for n = 1, 10 do
  list[n] = n + 0.0
end
for n = 1, 1000000 do
  i = n
  list[i % 10 + 1] = scale(list[i % 10 + 1], 2.5)
  sum = sum + list[3] / 1000
  list[3] = 1.0
end
",
    },
    Pair {
        name: "strings: concatenation, parts, comparison",
        statements: 5,
        karel: "PROGRAM strings
VAR
  i, hits : INTEGER
  word, part : STRING[20]
BEGIN
  hits = 0
  FOR i = 1 TO 1000000 DO
    word = 'cmd' + 'move'
    part = SUB_STR(word, 4, 4)
    IF part = 'move' THEN
      hits = hits + STR_LEN(part)
    ENDIF
  ENDFOR
END strings
",
        lua: "i, hits, word, part = 0, 0, '', ''
local cmd, move = 'cmd', 'move'
for n = 1, 1000000 do
  i = n
  word = cmd .. move
  part = string.sub(word, 4, 7)
  if part == 'move' then
    hits = hits + #part
  end
end
",
    },
];

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) fn run(repeats: usize) -> Result<()> {
    for pair in PAIRS {
        let mut rates = Vec::new();
        let mut ratios = Vec::new();
        for _ in 0..repeats {
            let begin = thread_time();
            let _instructions = machine::run(pair.karel)?;
            let karel = thread_time().saturating_sub(begin).as_secs_f64();
            let begin = thread_time();
            Lua::new()
                .load(pair.lua)
                .exec()
                .map_err(|error| anyhow::anyhow!("{error}"))?;
            let lua = thread_time().saturating_sub(begin).as_secs_f64();
            rates.push(f64::from(ROUNDS) * f64::from(pair.statements) / karel / 1e6);
            ratios.push(lua / karel);
        }
        println!(
            "| {}, statements a second | {:.1} million, {:.2}x as fast as Lua 5.4 | 5 million |",
            pair.name,
            median(rates),
            median(ratios)
        );
    }
    Ok(())
}
