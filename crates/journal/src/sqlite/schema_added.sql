-- Added to version 1: a journal without it has no record of the kind, so that an empty table is the right one.
CREATE TABLE IF NOT EXISTS decided (
    position INTEGER PRIMARY KEY,
    cell     TEXT NOT NULL
) STRICT;
CREATE INDEX IF NOT EXISTS decided_cell ON decided (cell, position);
