//! Valid programs, drawn from bytes: a grammar of templates whose holes `{x}` are filled by other templates.
//!
//! Every program is correct by construction, so one that the checker refuses is a finding as well. The first template
//! of each row needs nothing deeper: it is taken when the bytes or the depth are used up.

use std::fmt::Write as _;

use crate::choices::Choices;

/// Deepest nesting of templates.
const DEEPEST: usize = 9;
/// Longest text of a program.
const LONGEST: usize = 12_000;

/// A hole and what may stand there.
type Row = (&'static str, &'static [&'static str]);

#[rustfmt::skip]
const ROWS: &[Row] = &[
    // Variables.
    ("vi", &["i1", "i2", "i3", "ai[{at5}]", "s1.n", "s2[{at3}].n", "bt[{at3}]", "m[{at2},{at3}]"]),
    ("vI", &["i1", "i2", "i3"]),
    ("vr", &["r1", "r2", "ar[{at5}]", "s1.x", "p1.x", "p1.w", "v1.y", "q1.z", "e1.ext1"]),
    ("vR", &["r1", "r2", "r3", "r4", "r5", "r6"]),
    ("vb", &["b1", "b2", "s1.b"]),
    ("vt", &["t1", "t2", "s1.t", "at[{at3}]"]),
    ("vp", &["p1", "p2", "ap[{at3}]"]),
    ("vv", &["v1", "v2"]),
    ("vq", &["q1", "q2"]),
    ("vj", &["j1", "j2"]),
    ("any", &["{vi}", "{vr}", "{vb}", "{vt}", "p1", "v1", "q1", "j1", "ai", "s1", "s2[{at3}]", "c1"]),
    ("one", &["i1", "r1", "b1", "t1", "{vI}", "{vr}", "p1", "q1", "s1.t", "ai[{at3}]"]),
    ("k3", &["1", "2", "3", "i1"]),
    ("at2", &["1", "2", "(ABS({i} MOD 2) + 1)", "{vI}"]),
    ("at3", &["1", "2", "3", "(ABS({i} MOD 3) + 1)", "{vI}"]),
    ("at5", &["1", "5", "(ABS({i} MOD 5) + 1)", "{i}"]),
    ("ri", &["i2"]),
    // INTEGER.
    ("i", &["1", "0", "2", "7", "100", "(-3)", "2147483647", "{vi}", "{vi}", "({i} + {i})", "({i} - {i})", "({i} * {i})",
        "({i} DIV {i})", "({i} MOD {i})", "(-{i})", "ABS({i})", "ROUND({r})", "TRUNC({r})", "STR_LEN({t})", "INDEX({t}, {t})",
        "ORD({t}, {at3})", "ARRAY_LEN(ai)", "ARRAY_LEN(at)", "twice({i})", "by_ref(i3, {r})", "GIN[{at3}]", "GOUT[{at3}]",
        "AIN[{at3}]", "IO_STATUS(f1)", "PATH_LEN({pa})", "NODE_SIZE({pa})", "BYTES_LEFT(f1)", "$MCR.$GENOVERRIDE", "k5", "({i})", "MAXINT", "(NOT {i})", "({i} AND {i})"]),
    ("small", &["1", "3", "0", "10", "25"]),
    // REAL.
    ("r", &["1.5", "0.0", "(-2.25)", "1E10", "90", "{vr}", "{vr}", "({r} + {r})", "({r} - {i})", "({r} * {r})", "({i} / {i})",
        "({r} / {r})", "SIN({r})", "COS({r})", "TAN({r})", "ATAN2({r}, {r})", "SQRT(ABS({r}))", "EXP({r})", "LN({r})",
        "ACOS({r})", "ASIN({r})", "ABS({r})", "({v} @ {v})", "half({r})", "$SPEED", "(-{r})"]),
    // BOOLEAN.
    ("b", &["TRUE", "FALSE", "{vb}", "{i} = {i}", "({i} < {i})", "({r} >= {i})", "({t} = {t})", "({t} < {t})", "(NOT {vb})",
        "(({i} > {i}) AND ({b2}))", "(({b2}) OR {vb})", "UNINIT({any})", "DIN[{at3}]", "DOUT[{at3}]", "FLG[{at3}]",
        "IN_AUTO_MODE", "TP_ENABLED", "IN_RANGE({p})", "J_IN_RANGE(j1)", "({v} = {v})", "({q} >=< {q})", "RDI[{at3}]"]),
    ("b2", &["b1", "b2", "{i} > {i}", "NOT b1"]),
    // STRING.
    ("t", &["'abc'", "''", "'12 -3.5E2 x'", "'it''s'", "{vt}", "{vt}", "({t} + {t})", "CHR({i})", "SUB_STR({t}, {at3}, {small})",
        "CURR_PROG", "greet({t})", "'RD:A.TXT'", "'S3:'"]),
    // Positions and vectors.
    ("p", &["p1", "p2", "CURPOS(0, 0)", "{vp}", "shifted(p1, {r})", "GET_POS_REG({at3}, i1)"]),
    ("q", &["q1", "q2", "p1", "(q1 : q2)", "INV(q1)", "FRAME(q1, q2, p1)", "POS({r}, {r}, {r}, {r}, {r}, {r}, c1)", "$UTOOL", "$UFRAME"]),
    ("v", &["v1", "v2", "(v1 + v2)", "(v1 - {v2})", "(v1 # v2)", "(v1 * {r})", "({r} * v1)", "(v2 / {r})", "(q1 : v1)",
        "APPROACH(q1)", "ORIENT(q1)", "NORMAL(p1)"]),
    ("v2", &["v2", "v1"]),
    ("j", &["j1", "j2", "CURJPOS(0, 0)", "GET_JPOS_REG({at3}, i1)"]),
    // What WRITE takes.
    ("w", &["{i}", "{r}", "{b}", "{t}", "CR", "{i}::{small}", "{r}::{small}::2", "{r}::{small}::-2", "{t}::{small}", "{b}::{small}"]),
    ("rd", &["i1", "r1", "t1", "b1", "i2::{small}", "t2::{small}", "r2::3::2", "CR", "{vt}::1", "{vi}::4"]),
    ("file", &["'RD:A.TXT'", "'RD:B.DT'", "'MC:A.TXT'", "'PIP:P.DAT'", "'S3:'", "'C1:'", "'XX:A'", "'RD:..'", "{t}"]),
    ("mode", &["'RW'", "'RO'", "'AP'", "'UD'", "'x'"]),
    ("attr", &["ATR_UF", "ATR_IA", "ATR_EOL", "ATR_TIMEOUT", "ATR_PIPWAIT", "ATR_REVERSE", "ATR_FIELD", "ATR_PASSALL"]),
    ("task", &["'HELPER'", "'FUZZED'", "'NONE'", "{t}"]),
    ("path", &["'*SYSTEM*', '$MCR.$GENOVERRIDE'", "'HELPER', 'COUNT'", "'FUZZED', 'S1.N'", "'FUZZED', 'AI[2]'", "'FUZZED', 'S2[2].T'",
        "'*SYSTEM*', '$MNUFRAME[1,2]'", "'*SYSTEM*', {t}", "{t}, {t}", "'*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT'"]),
    // Statements.
    ("s", &["i1 = i1 + 1", "{vi} = {i}", "{vr} = {r}", "{vb} = {b}", "{vt} = {t}", "{vp} = {p}", "{vv} = {v}", "{vq} = {q}",
        "{vj} = {j}", "ai = ao", "s2[{at3}] = s1", "s1 = s2[{at3}]", "e1 = CURPOS(0, 0)", "p1 = q1", "q1 = {p}",
        "IF {b} THEN\n{l}ENDIF", "IF {b} THEN\n{l}ELSE\n{l}ENDIF", "WHILE {b} DO\n{l}ENDWHILE", "REPEAT\n{l}UNTIL {b}",
        "FOR {vI} = {i} TO {i} DO\n{l}ENDFOR", "FOR {vI} = {small} DOWNTO 0 DO\n{l}ENDFOR",
        "SELECT {i} OF\nCASE (1, 2):\n{l}CASE (-3):\n{l}ELSE:\n{l}ENDSELECT", "SELECT {small} OF\nCASE (1):\n{l}ENDSELECT",
        "USING s1 DO\nn = {i}\n{l}ENDUSING", "IF {b} THEN\nGOTO done\nENDIF", "GOTO done", "again::\nIF {b} THEN\nGOTO again\nENDIF",
        "poke(i1, ai)", "poke(ai[{at5}], ao)", "count_down({small})", "put_all(s1)", "RETURN", "ABORT", "PAUSE",
        "WRITE ({w})", "WRITE ({w}, {w}, CR)", "WRITE f1({w}, {w})", "READ f1({rd})", "READ f1({rd}, {rd}, {rd})",
        "OPEN FILE f1({mode}, {file})", "CLOSE FILE f1", "CANCEL FILE f1", "SET_FILE_ATR(f1, {attr}, {i})", "SET_FILE_ATR(f1, {attr})",
        "BYTES_AHEAD(f1, {vI}, i1)", "CLR_IO_STAT(f1)", "MSG_DISCO({t}, i1)", "MSG_PING({t}, i1)",
        "COPY_FILE({file}, {file}, {b}, FALSE, i1)", "DELETE_FILE({file}, FALSE, i1)", "RENAME_FILE({file}, {t}, FALSE, i1)",
        "FILE_LIST('RD:*.*', {i}, {i}, at, i2, i1)", "FORMAT_DEV('RD:', '', FALSE, i1)", "MOUNT_DEV('MC:', i1)", "DISMOUNT_DEV('MC:', i1)",
        "CNV_INT_STR({i}, {small}, {i}, {vt})", "CNV_REAL_STR({r}, {small}, {small}, {vt})", "CNV_STR_INT({t}, {vI})", "CNV_STR_REAL({t}, {vR})",
        "CNV_CONF_STR(c1, {vt})", "CNV_STR_CONF({t}, c1, i1)", "CNV_TIME_STR({i}, {vt})", "CNV_STR_TIME({t}, i1)", "GET_TIME(i1)",
        "SET_INT_REG({i}, {i}, i1)", "SET_REAL_REG({at3}, {r}, i1)", "GET_REG({at3}, b1, i2, r1, i1)", "SET_STR_REG({at3}, {t}, i1)",
        "GET_STR_REG({at3}, {vt}, i1)", "SET_POS_REG({at3}, {p}, i1)", "SET_EPOS_REG({at3}, e1, i1)", "SET_JPOS_REG({at3}, {j}, i1)",
        "CLR_POS_REG({at3}, 1, i1)", "POS_REG_TYPE({at3}, 1, i2, i3, i1)", "SET_REG_CMT({at3}, {t}, i1)", "GET_REG_CMT({at3}, {vt}, i1)",
        "SET_PORT_VAL(2, {i}, {i}, i1)", "GET_PORT_VAL({at5}, {i}, i2, i1)", "SET_PORT_CMT({at3}, {i}, {t}, i1)", "GET_PORT_CMT({at3}, {i}, {vt}, i1)",
        "DOUT[{at3}] = {b}", "RDO[{at3}] = {b}", "FLG[{at3}] = {b}", "GOUT[{at3}] = {i}", "AOUT[{at3}] = {i}", "DOUT[{i}] = ON",
        "CNV_JPOS_REL({j1}, ar, i1)", "CNV_REL_JPOS(ar, {vj}, i1)", "UNPOS(q1, r1, r2, r3, r4, r5, r6, c1)",
        "CHECK_EPOS(e1, q1, q2, i1)", "JOINT2POS(j1, q1, q2, 0, p1, c1, ar, i1)", "POS2JOINT(p1, q1, q2, 0, c1, ar, j1, i1)",
        "SET_VAR(i2, {path}, {one}, i1)", "GET_VAR(i2, {path}, {one}, i1)", "$MCR.$GENOVERRIDE = {i}", "$SPEED = {r}", "$UTOOL = {q}",
        "$UFRAME = q1", "$MOTYPE = {mt}", "MOVE TO {p}", "MOVE TO {p} NOWAIT", "MOVE TO {p}, UNTIL {b3}", "MOVE TO q1 NOWAIT",
        "MOVE TO {p} NOWAIT,\nWHEN {c} DO\n{a}ENDMOVE",
        "MOVE TO {p} VIA {p}", "MOVE NEAR {p} BY {r}", "MOVE NEAR {p} BY {r} NOWAIT", "MOVE AXIS {at5} BY {r}", "MOVE RELATIVE {vv}",
        "MOVE AWAY {r}", "MOVE AWAY {r} NOWAIT, UNTIL {b3}", "MOVE ABOUT {vv} BY {r}", "MOVE ALONG way", "MOVE ALONG way NOWAIT",
        "MOVE ALONG way[{at3}..{at3}]", "MOVE ALONG route", "MOVE ALONG way,\nWHEN {nd} DO\n{a}WHEN {nd} DO\n{a}ENDMOVE",
        "$TERMTYPE = {tt}", "OPEN HAND {at3}", "CLOSE HAND {i}", "RELAX HAND {at3}", "CANCEL", "STOP", "HOLD", "RESUME", "UNHOLD", "ATTACH", "RELEASE",
        "DELAY {small}", "DELAY {i}", "WAIT FOR {b}", "WAIT FOR {c}", "SIGNAL EVENT[{small}]", "SIGNAL SEMAPHORE[{at3}]",
        "PEND_SEMA({at3}, {small}, b1)", "POST_SEMA({at3})", "CLEAR_SEMA({at3})", "PULSE DOUT[{at3}] FOR {small}", "PULSE DOUT[{at3}] FOR {small} NOWAIT",
        "CONNECT TIMER TO i3", "DISCONNECT TIMER i3",
        "CONDITION[{at3}]:\nWHEN {c} DO\n{a}ENDCONDITION", "CONDITION[{at3}]:\nWITH $SCAN_TIME = 16\nWHEN {c} DO\n{a}WHEN {c} DO\n{a}ENDCONDITION",
        "ENABLE CONDITION[{at3}]", "DISABLE CONDITION[{at3}]", "PURGE CONDITION[{at3}]",
        "RUN_TASK({task}, 0, FALSE, FALSE, 1, i1)", "ABORT_TASK({task}, TRUE, TRUE, i1)", "PAUSE_TASK({task}, TRUE, TRUE, i1)", "CONT_TASK({task}, i1)",
        "GET_TSK_INFO({vt}, i2, TSK_STATUS, i3, t2, i1)", "CALL_PROG({task}, i2)", "CALL_PROGLIN({task}, {i}, i2, FALSE)",
        "LOAD_STATUS({task}, b1, b2)", "PROG_LIST('*', 1, {small}, i2, at, i3, i1)", "POST_ERR({i}, {t}, {i}, {at3})",
        "ERR_DATA(i1, i2, {vt}, i3, t2, i2, i3, t1)", "ABORT PROGRAM[{i}]", "PAUSE PROGRAM[{i}]", "CONTINUE PROGRAM[{i}]",
        "APPEND_NODE({pa}, i1)", "INSERT_NODE({pa}, {at3}, i1)", "DELETE_NODE({pa}, {i}, i1)", "COPY_PATH(way, {small}, {small}, path2, i1)",
        "way[{at3}].node_pos = {q}", "route[{at3}].n = {i}", "route[{at3}].spot = {q}", "route.t = {t}", "nums[{at3}] = {i}",
        "IF PATH_LEN(route) > 0 THEN\n{vI} = route[1].n\nENDIF", "grow(route, {small})", "grow(boxes[{at3}].trips[{at2}], {small})", "boxes[{at3}].trips[{at2}][{at3}].n = {i}", "nest({small})",
        "COPY_PATH(route, {small}, {small}, boxes[{at3}].trips[{at2}], i1)", "SAVE('FUZZED', {file}, i1)", "LOAD({file}, 0, i1)", "CLEAR('FUZZED.VR', i1)",
        "CLEAR({t}, i1)", "CREATE_TPE({t}, 1, i1)", "SAVE_DRAM({task}, i1)", "i1 = GET_USEC_SUB(GET_USEC_TIM, {i})",
        "ADD_DICT({file}, {t}, '', 0, i1)", "WRITE_DICT_V(TPDISPLAY, {t}, {at3}, at, i1)", "POST_ERR_L({i}, {t}, {i}, 0)", "V_RUN_FIND({t}, {i}, i1)",
        "USING route[{at3}] DO\nn = {i}\n{l}ENDUSING",
        "INIT_QUEUE(qu)", "APPEND_QUEUE({i}, qu, qd, i2, i1)", "GET_QUEUE(qu, qd, {vI}, i1, i2)", "INSERT_QUEUE({i}, {i}, qu, qd, i1)",
        "DELETE_QUEUE({small}, qu, qd, i1)", "MODIFY_QUEUE({i}, {small}, qu, qd, i1)", "COPY_QUEUE(qu, qd, {small}, {small}, ao, i2, i1)",
        "FORCE_SPMENU(TP_PANEL, SPI_TPUSER, 1)", "SET_LANG({t}, i1)", "bump", "far_count = far_count + {i}"]),
    ("mt", &["JOINT", "LINEAR", "CIRCULAR"]),
    ("tt", &["FINE", "COARSE", "NOSETTLE", "NODECEL", "VARDECEL"]),
    ("pa", &["way", "route", "nums", "path2", "box1.way", "boxes[{at3}].trips[{at2}]"]),
    ("nd", &["AT NODE[{small}]", "AT NODE[*]", "TIME {small} AFTER NODE[{k3}]", "TIME {small} BEFORE NODE[{k3}]", "{c}"]),
    ("j1", &["j1", "j2"]),
    // Conditions and actions of handlers.
    ("c", &["{b3}", "EVENT[{small}]", "SEMAPHORE[{k3}]", "ERROR[*]", "ERROR[12311]", "DIN[{k3}]+", "DOUT[{k3}]-", "FLG[1]+ OR FLG[2]-",
        "ABORT", "PAUSE", "CONTINUE", "ABORT PROGRAM[1]", "{b3}, EVENT[2]", "{b3} AND {b3}"]),
    ("b3", &["(i1 > {small})", "b1", "DIN[1]", "(DOUT[{k3}] = ON)", "(r1 < 2.5)", "FLG[{k3}]"]),
    ("a", &["i2 = i2 + 1\n", "{act}\n{a}", "{act}\n"]),
    ("act", &["i1 = {small}", "bump", "NOABORT", "NOPAUSE", "UNPAUSE", "NOMESSAGE", "ABORT", "PAUSE", "CONTINUE", "SIGNAL EVENT[{small}]",
        "SIGNAL SEMAPHORE[{at3}]", "ENABLE CONDITION[{at3}]", "DISABLE CONDITION[{at3}]", "CANCEL", "STOP", "RESUME", "HOLD", "UNHOLD",
        "DOUT[{at3}] = ON", "PULSE DOUT[1] FOR 8 NOWAIT", "CANCEL FILE f1", "WRITE ('act', i1, CR)", "GOUT[1] = {small}", "i3 = {i}"]),
    ("l", &["{s}\n", "{s}\n{s}\n", "{s}\n{s}\n{s}\n{s}\n", ""]),
    ("main", &["{s}\n", "{s}\n{main}", "{s}\n{s}\n{s}\n{main}", "{s}\n{s}\n{s}\n{s}\n{s}\n{main}"]),
];

const HEAD: &str = "PROGRAM fuzzed
%NOLOCKGROUP
%ALPHABETIZE
CONST
  k5 = 5
TYPE
  rec = STRUCTURE
    n : INTEGER
    x : REAL
    b : BOOLEAN
    t : STRING[10]
  ENDSTRUCTURE
  stop = STRUCTURE
    n : INTEGER
    spot : POSITION
  ENDSTRUCTURE
  trip = PATH PATHHEADER = rec, NODEDATA = stop
  box = STRUCTURE
    way : PATH
    trips : ARRAY[2] OF trip
  ENDSTRUCTURE
VAR
  box1 IN CMOS : box
  boxes : ARRAY[3] OF box
  way, path2 : PATH
  route : trip
  nums : PATH NODEDATA = INTEGER
  qu : QUEUE_TYPE
  qd : ARRAY[4] OF INTEGER
  i1, i2, i3 : INTEGER
  r1, r2, r3, r4, r5, r6 : REAL
  b1, b2 : BOOLEAN
  t1 : STRING[20]
  t2 : STRING[5]
  ai, ao : ARRAY[5] OF INTEGER
  ar : ARRAY[9] OF REAL
  at : ARRAY[3] OF STRING[8]
  bt : ARRAY[3] OF BYTE
  m : ARRAY[2, 3] OF INTEGER
  s1 IN CMOS : rec
  s2 : ARRAY[3] OF rec
  p1, p2 : XYZWPR
  ap : ARRAY[3] OF XYZWPR
  e1 : XYZWPREXT
  q1, q2 : POSITION
  v1, v2 : VECTOR
  j1, j2 : JOINTPOS6
  c1 : CONFIG
  f1 : FILE
  far_count FROM helper : INTEGER
ROUTINE bump FROM fuzzed
ROUTINE twice(n : INTEGER) : INTEGER
BEGIN
  IF n > 1000 THEN
    RETURN (n)
  ENDIF
  RETURN (2 * n)
END twice
ROUTINE by_ref(n : INTEGER; x : REAL) : INTEGER
BEGIN
  n = n + 1
  RETURN (n)
END by_ref
ROUTINE half(x : REAL) : REAL
BEGIN
  RETURN (x / 2)
END half
ROUTINE greet(t : STRING) : STRING[12]
BEGIN
  RETURN ('<' + t + '>')
END greet
ROUTINE shifted(at : XYZWPR; by : REAL) : XYZWPR
VAR there : XYZWPR
BEGIN
  there = at
  there.z = at.z + by
  RETURN (there)
END shifted
ROUTINE poke(n : INTEGER; list : ARRAY OF INTEGER)
BEGIN
  list[1] = n
  n = ARRAY_LEN(list)
END poke
ROUTINE grow(p : trip; n : INTEGER)
VAR s : INTEGER
BEGIN
  APPEND_NODE(p, s)
  p[PATH_LEN(p)].n = n
  p[PATH_LEN(p)].spot = CURPOS(0, 0)
END grow
ROUTINE nest(n : INTEGER)
VAR
  own : trip
  more : ARRAY[2] OF box
BEGIN
  grow(own, n)
  grow(more[2].trips[1], n)
  IF n > 0 THEN
    nest((n - 1))
  ENDIF
END nest
ROUTINE count_down(n : INTEGER)
BEGIN
  IF n > 0 THEN
    count_down((n - 1))
  ENDIF
END count_down
";

const START: &str =
    "  i1 = 1; i2 = 2; i3 = 3; r1 = 1; r2 = 2.5; b1 = TRUE; b2 = FALSE; t1 = 'one'; t2 = 'two'
  p1 = CURPOS(0, 0); p2 = p1; q1 = p1; q2 = p1; e1 = CURPOS(0, 0); j1 = CURJPOS(0, 0); j2 = j1
  v1 = APPROACH(q1); v2 = ORIENT(q1); c1 = p1.config_data
  FOR i1 = 1 TO 5 DO ; ai[i1] = i1 ; ao[i1] = -i1 ; ENDFOR
  FOR i1 = 1 TO 9 DO ; ar[i1] = i1 ; ENDFOR
  FOR i1 = 1 TO 3 DO ; at[i1] = 'x' ; bt[i1] = i1 ; ap[i1] = p1 ; ENDFOR
  FOR i1 = 1 TO 3 DO ; APPEND_NODE(way, i2) ; way[i1].node_pos = q1 ; grow(route, i1) ; APPEND_NODE(nums, i2) ; nums[i1] = i1 ; ENDFOR
  INIT_QUEUE(qu) ; i2 = 2
  s1.n = 1; s1.x = 1; s1.b = TRUE; s1.t = 's'
";

/// The other program, which the drawn one starts, calls and shares a variable with.
pub const HELPER: &str = "PROGRAM helper
%NOLOCKGROUP
VAR
  count, n : INTEGER
  far_count : INTEGER
BEGIN
  IF UNINIT(count) THEN
    count = 0
  ENDIF
  IF UNINIT(far_count) THEN
    far_count = 0
  ENDIF
  FOR n = 1 TO 3 DO
    count = count + 1
    DELAY 7
  ENDFOR
  WRITE ('helper', count, CR)
END helper
";

/// A correct program.
#[must_use]
pub fn program(choices: &mut Choices<'_>) -> String {
    let mut text = HEAD.to_owned();
    text.push_str("ROUTINE put_all(what : rec)\nBEGIN\n");
    fill(&mut text, "{l}", choices, 4);
    text.push_str("done::\nEND put_all\nBEGIN\n");
    text.push_str(START);
    let before = text.len();
    fill(&mut text, "{main}", choices, 0);
    debug_assert!(text.len() > before, "a body");
    text.push_str("done::\nEND fuzzed\nROUTINE bump\nBEGIN\n  i3 = i3 + 1\n");
    fill(&mut text, "{l}", choices, 4);
    text.push_str("done::\nEND bump\n");
    number_labels(&text)
}

/// Appends a template with its holes filled.
fn fill(text: &mut String, template: &str, choices: &mut Choices<'_>, depth: usize) {
    let mut rest = template;
    while let Some((before, behind)) = rest.split_once('{') {
        text.push_str(before);
        let (hole, after) = behind.split_once('}').expect("a hole ends");
        let templates = templates_of(hole);
        let shallow = depth >= DEEPEST || choices.is_over() || text.len() > LONGEST;
        let chosen = if shallow {
            templates.first().expect("a row has a template")
        } else {
            choices.one_of(templates)
        };
        fill(text, chosen, choices, depth + 1);
        rest = after;
    }
    text.push_str(rest);
}

/// Labels are of their routine: `again` gets a number of its own, with the GOTO behind it.
fn number_labels(text: &str) -> String {
    let mut number = 0;
    let mut open = Vec::new();
    let mut numbered = String::with_capacity(text.len());
    for line in text.lines() {
        match line {
            "again::" => {
                number += 1;
                open.push(number);
                let _written = write!(numbered, "again{number}::");
            }
            "GOTO again" => {
                let target = open.pop().expect("a label stands before its GOTO");
                let _written = write!(numbered, "GOTO again{target}");
            }
            other => numbered.push_str(other),
        }
        numbered.push('\n');
    }
    numbered
}

/// A program whose main body is one statement: the template with this number of row `s`, if there is one.
#[must_use]
pub fn one_statement(number: usize, choices: &mut Choices<'_>) -> Option<String> {
    let template = templates_of("s").get(number)?;
    let mut body = String::new();
    fill(&mut body, template, choices, 3);
    Some(program_of(&body))
}

/// A program with these statements as its main body.
pub(crate) fn program_of(body: &str) -> String {
    let text = format!(
        "{HEAD}ROUTINE put_all(what : rec)\nBEGIN\nEND put_all\nBEGIN\n{START}{body}\ndone::\nEND fuzzed\n\
         ROUTINE bump\nBEGIN\n  i3 = i3 + 1\nEND bump\n"
    );
    number_labels(&text)
}

/// What may stand in a hole.
///
/// # Panics
/// If the grammar has no such row.
pub(crate) fn templates_of(hole: &str) -> &'static [&'static str] {
    let row = ROWS.iter().find(|(name, _)| *name == hole);
    let (_, templates) = row.unwrap_or_else(|| panic!("no row {hole}"));
    templates
}
