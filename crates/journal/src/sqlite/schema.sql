-- Version 1. `records` is the truth; the other tables are what the records amount to, changed in the same
-- transaction, and `verify` builds them again and compares.
CREATE TABLE records (
    position INTEGER PRIMARY KEY,
    previous BLOB NOT NULL,
    body     TEXT NOT NULL,
    hash     BLOB NOT NULL
) STRICT;

CREATE TABLE motions (
    motion   TEXT NOT NULL PRIMARY KEY,
    phase    TEXT NOT NULL,
    intent   INTEGER NOT NULL,
    accepted INTEGER,
    outcome  INTEGER,
    decision INTEGER
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX motions_intent ON motions (intent);
CREATE INDEX motions_unfinished ON motions (intent) WHERE phase <> 'closed';

CREATE TABLE jobs (
    job     TEXT NOT NULL PRIMARY KEY,
    created INTEGER NOT NULL,
    latest  INTEGER NOT NULL,
    ended   INTEGER
) STRICT, WITHOUT ROWID;
CREATE INDEX jobs_open ON jobs (created) WHERE ended IS NULL;

CREATE TABLE keys (
    key      TEXT NOT NULL PRIMARY KEY,
    body     BLOB NOT NULL,
    position INTEGER NOT NULL,
    used_ms  INTEGER NOT NULL,
    motion   TEXT
) STRICT, WITHOUT ROWID;
CREATE INDEX keys_used ON keys (used_ms);
CREATE INDEX keys_position ON keys (position);

CREATE TABLE head (
    id        INTEGER PRIMARY KEY CHECK (id = 1),
    position  INTEGER NOT NULL,
    hash      BLOB NOT NULL,
    epoch     INTEGER NOT NULL,
    max_age_s INTEGER NOT NULL,
    max_count INTEGER NOT NULL
) STRICT;
