-- First schema. What each table and column means: README.md.

CREATE TABLE migration (
  version INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  applied_at_utc_us INTEGER NOT NULL
) STRICT;

CREATE TABLE machine (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  revision INTEGER NOT NULL CHECK (revision >= 1),
  created_at_utc_us INTEGER NOT NULL,
  deleted_at_utc_us INTEGER
) STRICT;

CREATE TABLE machine_revision (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  revision INTEGER NOT NULL,
  description_json TEXT NOT NULL,
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  PRIMARY KEY (machine_id, revision)
) STRICT, WITHOUT ROWID;

CREATE TABLE session (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  name TEXT NOT NULL,
  instrument TEXT NOT NULL,
  measured_at_utc_us INTEGER,
  state INTEGER NOT NULL CHECK (state BETWEEN 1 AND 4),
  next_seq INTEGER NOT NULL CHECK (next_seq >= 0),
  reading_count INTEGER NOT NULL CHECK (reading_count >= 0),
  hash TEXT CHECK ((hash IS NOT NULL) = (state = 2)),
  created_by TEXT NOT NULL,
  request_id TEXT,
  body_sha256 TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  last_seen_at_utc_us INTEGER NOT NULL,
  closed_at_utc_us INTEGER CHECK ((closed_at_utc_us IS NULL) = (state = 1))
) STRICT;
CREATE UNIQUE INDEX session_by_request ON session (created_by, request_id) WHERE request_id IS NOT NULL;
CREATE INDEX session_by_machine ON session (machine_id, id);
CREATE INDEX session_open ON session (last_seen_at_utc_us) WHERE state = 1;

CREATE TABLE session_header (
  session_id INTEGER NOT NULL REFERENCES session (id),
  position INTEGER NOT NULL,
  key TEXT NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE session_column (
  session_id INTEGER NOT NULL REFERENCES session (id),
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  is_text INTEGER NOT NULL CHECK (is_text IN (0, 1)),
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE chunk (
  session_id INTEGER NOT NULL REFERENCES session (id),
  seq INTEGER NOT NULL CHECK (seq >= 0),
  reading_count INTEGER NOT NULL CHECK (reading_count > 0),
  crc32c INTEGER NOT NULL,
  content BLOB NOT NULL,
  PRIMARY KEY (session_id, seq)
) STRICT, WITHOUT ROWID;

CREATE TABLE job (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  machine_id INTEGER REFERENCES machine (id),
  params BLOB NOT NULL,
  input_hash TEXT NOT NULL,
  priority INTEGER NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 1 AND 6),
  attempt INTEGER NOT NULL CHECK (attempt >= 0),
  max_attempts INTEGER NOT NULL CHECK (max_attempts >= 1),
  owner TEXT CHECK ((owner IS NOT NULL) = (state = 2)),
  lease_token INTEGER NOT NULL,
  lease_until_steady_us INTEGER CHECK ((lease_until_steady_us IS NOT NULL) = (state = 2)),
  cancel_requested INTEGER NOT NULL CHECK (cancel_requested IN (0, 1)),
  progress_stage TEXT NOT NULL,
  progress_fraction REAL NOT NULL,
  progress_detail TEXT NOT NULL,
  result BLOB CHECK ((result IS NOT NULL) = (state = 3)),
  error_code INTEGER,
  error_reason TEXT,
  error_message TEXT,
  created_by TEXT NOT NULL,
  request_id TEXT,
  body_sha256 TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  run_after_utc_us INTEGER NOT NULL,
  started_at_utc_us INTEGER,
  ended_at_utc_us INTEGER,
  version INTEGER NOT NULL
) STRICT;
CREATE UNIQUE INDEX job_by_request ON job (created_by, request_id) WHERE request_id IS NOT NULL;
CREATE INDEX job_waiting ON job (priority DESC, id, run_after_utc_us) WHERE state = 1;
CREATE INDEX job_running ON job (owner, lease_until_steady_us) WHERE state = 2;
CREATE INDEX job_by_machine ON job (machine_id, id);
CREATE INDEX job_by_input ON job (input_hash, id) WHERE input_hash <> '';

CREATE TABLE job_attempt (
  job_id INTEGER NOT NULL REFERENCES job (id),
  lease_token INTEGER NOT NULL,
  attempt INTEGER NOT NULL,
  owner TEXT NOT NULL,
  started_at_utc_us INTEGER NOT NULL,
  ended_at_utc_us INTEGER,
  outcome TEXT,
  message TEXT,
  PRIMARY KEY (job_id, lease_token)
) STRICT, WITHOUT ROWID;

CREATE TABLE program (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 1 AND 4),
  byte_count INTEGER NOT NULL CHECK (byte_count >= 0),
  sha256 TEXT CHECK ((sha256 IS NOT NULL) = (state = 2)),
  same_as INTEGER REFERENCES program (id) CHECK ((same_as IS NOT NULL) = (state = 3)),
  created_by TEXT NOT NULL,
  request_id TEXT,
  body_sha256 TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  last_seen_at_utc_us INTEGER NOT NULL
) STRICT;
CREATE INDEX program_open ON program (last_seen_at_utc_us) WHERE state = 1;
CREATE UNIQUE INDEX program_by_content ON program (sha256, kind) WHERE sha256 IS NOT NULL;
CREATE UNIQUE INDEX program_by_request ON program (created_by, request_id) WHERE request_id IS NOT NULL;

CREATE TABLE program_part (
  program_id INTEGER NOT NULL REFERENCES program (id),
  first_byte INTEGER NOT NULL CHECK (first_byte >= 0),
  byte_count INTEGER NOT NULL CHECK (byte_count > 0),
  crc32c INTEGER NOT NULL,
  content BLOB NOT NULL,
  PRIMARY KEY (program_id, first_byte)
) STRICT, WITHOUT ROWID;

CREATE TABLE job_program (
  job_id INTEGER NOT NULL REFERENCES job (id),
  position INTEGER NOT NULL,
  program_id INTEGER NOT NULL REFERENCES program (id),
  PRIMARY KEY (job_id, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE calibration (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  version INTEGER NOT NULL CHECK (version >= 1),
  machine_revision INTEGER NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 1 AND 3),
  etag INTEGER NOT NULL,
  job_id INTEGER REFERENCES job (id),
  measured_at_utc_us INTEGER NOT NULL CHECK (measured_at_utc_us >= 0),
  model_json TEXT NOT NULL,
  options_json TEXT NOT NULL,
  report_json TEXT NOT NULL,
  engine_version TEXT NOT NULL,
  rank INTEGER NOT NULL,
  condition REAL,
  chi2_per_dof REAL,
  rms_before_um REAL,
  rms_after_um REAL,
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  approved_by TEXT,
  approved_at_utc_us INTEGER,
  retired_at_utc_us INTEGER,
  FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revision (machine_id, revision)
) STRICT;
CREATE UNIQUE INDEX calibration_by_machine ON calibration (machine_id, version);
CREATE UNIQUE INDEX calibration_approved ON calibration (machine_id) WHERE state = 2;
CREATE UNIQUE INDEX calibration_by_job ON calibration (job_id) WHERE job_id IS NOT NULL;

CREATE TABLE calibration_session (
  calibration_id INTEGER NOT NULL REFERENCES calibration (id),
  position INTEGER NOT NULL,
  session_id INTEGER NOT NULL REFERENCES session (id),
  PRIMARY KEY (calibration_id, position)
) STRICT, WITHOUT ROWID;

-- Clustered as it is asked for: one machine, one symbol, a range of time.
CREATE TABLE estimate (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  symbol TEXT NOT NULL,
  measured_at_utc_us INTEGER NOT NULL,
  calibration_id INTEGER NOT NULL REFERENCES calibration (id),
  position INTEGER NOT NULL,
  unit INTEGER NOT NULL CHECK (unit IN (1, 2)),
  identifiable INTEGER NOT NULL CHECK (identifiable IN (0, 1)),
  estimated_um_urad REAL CHECK ((estimated_um_urad IS NOT NULL) = (identifiable = 1)),
  sigma_um_urad REAL,
  PRIMARY KEY (machine_id, symbol, measured_at_utc_us, calibration_id)
) STRICT, WITHOUT ROWID;

-- Sums of `estimate` over whole weeks, kept with it, so that ten years of all symbols need not be read row by row.
CREATE TABLE estimate_week (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  symbol TEXT NOT NULL,
  week INTEGER NOT NULL,
  unit INTEGER NOT NULL,
  estimate_count INTEGER NOT NULL,
  not_identifiable_count INTEGER NOT NULL,
  min_um_urad REAL,
  max_um_urad REAL,
  sum_um_urad REAL,
  first_at_utc_us INTEGER,
  last_at_utc_us INTEGER,
  last_sigma_um_urad REAL,
  last_calibration_id INTEGER,
  PRIMARY KEY (machine_id, symbol, week)
) STRICT, WITHOUT ROWID;

CREATE TABLE audit (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  at_utc_us INTEGER NOT NULL,
  principal TEXT NOT NULL,
  action TEXT NOT NULL,
  resource TEXT NOT NULL,
  outcome TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;

CREATE TRIGGER audit_is_never_changed BEFORE UPDATE ON audit BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;
CREATE TRIGGER audit_is_never_deleted BEFORE DELETE ON audit BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;

-- Raw measurements are never changed: chunks are only added to an open session and only leave with one that is given up.
CREATE TRIGGER chunk_is_never_changed BEFORE UPDATE ON chunk BEGIN SELECT RAISE (ABORT, 'a chunk is never changed'); END;
CREATE TRIGGER complete_session_keeps_its_chunks BEFORE DELETE ON chunk
WHEN (SELECT state FROM session WHERE id = OLD.session_id) = 2
BEGIN SELECT RAISE (ABORT, 'a complete session keeps its chunks'); END;
