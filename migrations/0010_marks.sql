-- What people say has happened to a machine: it ends what its history said before (docs/drift.md).

CREATE TABLE mark (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  at_utc_us INTEGER NOT NULL CHECK (at_utc_us >= 0),
  kind INTEGER NOT NULL CHECK (kind BETWEEN 1 AND 3),
  note TEXT NOT NULL,
  created_by TEXT NOT NULL,
  request_id TEXT,
  body_sha256 TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  withdrawn_by TEXT,
  withdrawn_at_utc_us INTEGER CHECK ((withdrawn_at_utc_us IS NULL) = (withdrawn_by IS NULL))
) STRICT;
CREATE INDEX mark_of_machine ON mark (machine_id, id);
CREATE UNIQUE INDEX mark_by_request ON mark (created_by, request_id) WHERE request_id IS NOT NULL;

-- The errors that it can have moved; none: all.
CREATE TABLE mark_symbol (
  mark_id INTEGER NOT NULL REFERENCES mark (id),
  position INTEGER NOT NULL,
  symbol TEXT NOT NULL,
  PRIMARY KEY (mark_id, position)
) STRICT, WITHOUT ROWID;
