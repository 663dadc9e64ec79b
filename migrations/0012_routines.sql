-- What runs by itself when sessions have come, and what became of each time it ran (docs/routines.md).

CREATE TABLE routine (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  scope INTEGER NOT NULL CHECK (scope IN (2, 3)),
  scope_name TEXT NOT NULL,
  principal TEXT NOT NULL,
  within_hours INTEGER NOT NULL CHECK (within_hours > 0),
  at_utc_minute INTEGER CHECK (at_utc_minute BETWEEN 0 AND 1439),
  work INTEGER NOT NULL CHECK (work IN (1, 2)),
  max_effects INTEGER,
  budget_json TEXT NOT NULL,
  monte_carlo_runs INTEGER,
  monte_carlo_seed INTEGER NOT NULL,
  approve_within_um REAL CHECK (approve_within_um > 0),
  is_enabled INTEGER NOT NULL CHECK (is_enabled IN (0, 1)),
  note TEXT NOT NULL,
  after_session_id INTEGER NOT NULL,
  etag INTEGER NOT NULL CHECK (etag >= 1),
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  changed_by TEXT NOT NULL,
  changed_at_utc_us INTEGER NOT NULL,
  removed_by TEXT NOT NULL,
  removed_at_utc_us INTEGER
) STRICT;
CREATE UNIQUE INDEX routine_name ON routine (name) WHERE removed_at_utc_us IS NULL;

-- Its lists: names of sessions to fit (1) and to prove on (2), errors to fit (3).
CREATE TABLE routine_text (
  routine_id INTEGER NOT NULL REFERENCES routine (id),
  list INTEGER NOT NULL CHECK (list BETWEEN 1 AND 3),
  position INTEGER NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (routine_id, list, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE routine_stop (
  routine_id INTEGER NOT NULL REFERENCES routine (id),
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  by TEXT NOT NULL,
  note TEXT NOT NULL,
  at_utc_us INTEGER NOT NULL,
  PRIMARY KEY (routine_id, machine_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE routine_run (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  routine_id INTEGER NOT NULL REFERENCES routine (id),
  routine_etag INTEGER NOT NULL,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  principal TEXT NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 1 AND 7),
  job_id INTEGER REFERENCES job (id),
  calibration_id INTEGER REFERENCES calibration (id),
  text TEXT NOT NULL,
  began_at_utc_us INTEGER NOT NULL,
  ended_at_utc_us INTEGER
) STRICT;
-- One at a time on a machine.
CREATE UNIQUE INDEX run_open ON routine_run (routine_id, machine_id) WHERE state <= 2;
CREATE INDEX run_open_of_machine ON routine_run (machine_id) WHERE state <= 2;
CREATE INDEX run_of_routine ON routine_run (routine_id, id);
CREATE INDEX run_of_routine_machine ON routine_run (routine_id, machine_id, id);
CREATE INDEX run_of_machine ON routine_run (machine_id, id);

CREATE TABLE routine_run_session (
  run_id INTEGER NOT NULL REFERENCES routine_run (id),
  position INTEGER NOT NULL,
  is_check INTEGER NOT NULL CHECK (is_check IN (0, 1)),
  name TEXT NOT NULL,
  session_id INTEGER NOT NULL REFERENCES session (id),
  PRIMARY KEY (run_id, position)
) STRICT, WITHOUT ROWID;
