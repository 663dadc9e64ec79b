-- Cells beside machines, as they say themselves how they stand (docs/cell.md).

CREATE TABLE cell (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  name TEXT NOT NULL,
  reported_by TEXT NOT NULL,
  reported_at_utc_us INTEGER NOT NULL,
  reported_at_up_us INTEGER NOT NULL,
  version TEXT NOT NULL,
  silent_after_s INTEGER NOT NULL CHECK (silent_after_s > 0),
  problem TEXT NOT NULL,
  waiting_files INTEGER NOT NULL CHECK (waiting_files >= 0),
  waiting_bytes INTEGER NOT NULL CHECK (waiting_bytes >= 0),
  quarantined_files INTEGER NOT NULL CHECK (quarantined_files >= 0),
  quarantined_bytes INTEGER NOT NULL CHECK (quarantined_bytes >= 0),
  max_bytes INTEGER NOT NULL CHECK (max_bytes >= 0)
) STRICT;
CREATE UNIQUE INDEX cell_name ON cell (machine_id, name);
