-- What is expected of machines, and what is told to people where it is not so (docs/events.md).

CREATE TABLE expectation (
  machine_id INTEGER PRIMARY KEY REFERENCES machine (id),
  etag INTEGER NOT NULL CHECK (etag >= 1),
  calibration_days INTEGER CHECK (calibration_days > 0),
  counts_candidates INTEGER NOT NULL CHECK (counts_candidates IN (0, 1)),
  changed_by TEXT NOT NULL,
  changed_at_utc_us INTEGER NOT NULL
) STRICT;

CREATE TABLE expected_tolerance (
  machine_id INTEGER NOT NULL REFERENCES expectation (machine_id),
  symbol TEXT NOT NULL,
  low_um_urad REAL NOT NULL,
  high_um_urad REAL NOT NULL CHECK (low_um_urad < high_um_urad),
  PRIMARY KEY (machine_id, symbol)
) STRICT, WITHOUT ROWID;

CREATE TABLE expected_session (
  machine_id INTEGER NOT NULL REFERENCES expectation (machine_id),
  name TEXT NOT NULL,
  every_hours INTEGER NOT NULL CHECK (every_hours > 0),
  PRIMARY KEY (machine_id, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  kind INTEGER NOT NULL CHECK (kind >= 1),
  subject TEXT NOT NULL,
  text TEXT NOT NULL,
  advice TEXT NOT NULL,
  certainty REAL,
  calibration_id INTEGER REFERENCES calibration (id),
  from_utc_us INTEGER,
  to_utc_us INTEGER,
  raised_at_utc_us INTEGER NOT NULL,
  cleared_at_utc_us INTEGER,
  cleared_why TEXT NOT NULL,
  acknowledged_at_utc_us INTEGER,
  acknowledged_by TEXT NOT NULL,
  acknowledged_note TEXT NOT NULL,
  shelved_until_utc_us INTEGER,
  shelved_by TEXT NOT NULL,
  shelved_note TEXT NOT NULL
) STRICT;
CREATE INDEX event_of_machine ON event (machine_id, id);
-- What stands is there once. Steps (kind 3) are told apart by their dates.
CREATE UNIQUE INDEX event_standing ON event (machine_id, kind, subject, iif(kind = 3, from_utc_us, 0))
  WHERE cleared_at_utc_us IS NULL;
CREATE INDEX event_open_of_machine ON event (machine_id, id) WHERE cleared_at_utc_us IS NULL;
CREATE INDEX event_open ON event (id) WHERE cleared_at_utc_us IS NULL;
CREATE INDEX event_step ON event (machine_id) WHERE kind = 3;
CREATE INDEX event_shelved ON event (shelved_until_utc_us) WHERE shelved_until_utc_us IS NOT NULL;

CREATE TABLE event_amount (
  event_id INTEGER NOT NULL REFERENCES event (id),
  position INTEGER NOT NULL,
  symbol TEXT NOT NULL,
  unit INTEGER NOT NULL CHECK (unit IN (1, 2)),
  size_um_urad REAL NOT NULL,
  sigma_um_urad REAL NOT NULL,
  PRIMARY KEY (event_id, position)
) STRICT, WITHOUT ROWID;

-- All that happened to events, in order: what a stream sends, and resumes at.
CREATE TABLE event_change (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  event_id INTEGER NOT NULL REFERENCES event (id),
  what INTEGER NOT NULL CHECK (what BETWEEN 1 AND 6),
  at_utc_us INTEGER NOT NULL,
  by TEXT NOT NULL,
  note TEXT NOT NULL
) STRICT;

-- How often what the events of a machine follow from has changed, and how often it had when it was looked at last, by which
-- version of axiscal.
CREATE TABLE event_look (
  machine_id INTEGER PRIMARY KEY REFERENCES machine (id),
  changes INTEGER NOT NULL,
  looked_at INTEGER NOT NULL,
  looked_by TEXT NOT NULL
) STRICT;
CREATE INDEX event_look_due ON event_look (machine_id) WHERE changes <> looked_at;
CREATE INDEX event_look_by ON event_look (looked_by);
INSERT INTO event_look (machine_id, changes, looked_at, looked_by)
  SELECT id, 1, 0, '' FROM machine WHERE EXISTS (SELECT 1 FROM calibration WHERE machine_id = machine.id);

-- The newest session of a name.
CREATE INDEX session_by_name ON session (machine_id, name, state, id);
