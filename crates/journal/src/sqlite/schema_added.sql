-- Added to version 1: a journal without it has no record of the kind, so that an empty table is the right one.
CREATE TABLE IF NOT EXISTS decided (
    position INTEGER PRIMARY KEY,
    cell     TEXT NOT NULL
) STRICT;
CREATE INDEX IF NOT EXISTS decided_cell ON decided (cell, position);
-- Who did what, among all records. In JSON a quotation mark within a text has a backslash before it, so the words below
-- are found where the kind of the record stands and nowhere else.
CREATE INDEX IF NOT EXISTS records_audit ON records (position)
    WHERE instr(body, '"record":{"kind":"audit"') > 0;
-- What the decisions of a cell amount to, tied into the chain by the record that tells of it.
CREATE TABLE IF NOT EXISTS snapshots (
    cell     TEXT NOT NULL PRIMARY KEY,
    position INTEGER NOT NULL,
    covers   INTEGER NOT NULL,
    body     TEXT NOT NULL
) STRICT;
-- The last record that was removed; no row: none was.
CREATE TABLE IF NOT EXISTS base (
    id        INTEGER PRIMARY KEY CHECK (id = 1),
    position  INTEGER NOT NULL,
    hash      BLOB NOT NULL,
    epoch     INTEGER NOT NULL,
    max_age_s INTEGER NOT NULL,
    max_count INTEGER NOT NULL
) STRICT;
