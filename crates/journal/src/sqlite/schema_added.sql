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
