-- A file in use, of schema version 1: released, never edited.
BEGIN TRANSACTION;
CREATE TABLE migration (
  version INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  applied_at_utc_us INTEGER NOT NULL
) STRICT;
INSERT INTO migration VALUES(1,'0001_initial','fc981a1346b08f9536ab41a2105ee18068754c2f7873fbf2ccd6a4eb0ede3aef',1700000000000000);
CREATE TABLE machine (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  revision INTEGER NOT NULL CHECK (revision >= 1),
  created_at_utc_us INTEGER NOT NULL,
  deleted_at_utc_us INTEGER
) STRICT;
INSERT INTO machine VALUES(1,'mt',2,1700000000000000,NULL);
CREATE TABLE machine_revision (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  revision INTEGER NOT NULL,
  description_json TEXT NOT NULL,
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  PRIMARY KEY (machine_id, revision)
) STRICT, WITHOUT ROWID;
INSERT INTO machine_revision VALUES(1,1,'{}','cell',1700000000000000);
INSERT INTO machine_revision VALUES(1,2,'{"id":"mt"}','cell',1700000000000000);
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
INSERT INTO session VALUES(1,1,'CR','touch',NULL,2,3,30,'311370a3efa9983b38ad04f95aeea31521d8bed694122e50e2356bb53d8c270c','cell',NULL,'f45c92b2b890c02bad7a72e02b5c31314c86171d4fe0866e7df545a9ea031c0b',1700000000000000,1700000000000000,1700000000000000);
INSERT INTO session VALUES(2,1,'CR','touch',NULL,1,1,10,NULL,'cell','open','f45c92b2b890c02bad7a72e02b5c31314c86171d4fe0866e7df545a9ea031c0b',1700000000000000,1700000000000000,NULL);
CREATE TABLE session_header (
  session_id INTEGER NOT NULL REFERENCES session (id),
  position INTEGER NOT NULL,
  key TEXT NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;
INSERT INTO session_header VALUES(1,0,'machine','mt');
INSERT INTO session_header VALUES(1,1,'sigma_um','0.3');
INSERT INTO session_header VALUES(1,2,'plane A','0 0 0 0 0 1');
INSERT INTO session_header VALUES(2,0,'machine','mt');
INSERT INTO session_header VALUES(2,1,'sigma_um','0.3');
INSERT INTO session_header VALUES(2,2,'plane A','0 0 0 0 0 1');
CREATE TABLE session_column (
  session_id INTEGER NOT NULL REFERENCES session (id),
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  is_text INTEGER NOT NULL CHECK (is_text IN (0, 1)),
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;
INSERT INTO session_column VALUES(1,0,'t_s',0);
INSERT INTO session_column VALUES(1,1,'X_mm',0);
INSERT INTO session_column VALUES(1,2,'feature',1);
INSERT INTO session_column VALUES(2,0,'t_s',0);
INSERT INTO session_column VALUES(2,1,'X_mm',0);
INSERT INTO session_column VALUES(2,2,'feature',1);
CREATE TABLE chunk (
  session_id INTEGER NOT NULL REFERENCES session (id),
  seq INTEGER NOT NULL CHECK (seq >= 0),
  reading_count INTEGER NOT NULL CHECK (reading_count > 0),
  crc32c INTEGER NOT NULL,
  content BLOB NOT NULL,
  PRIMARY KEY (session_id, seq)
) STRICT, WITHOUT ROWID;
INSERT INTO chunk VALUES(1,0,10,723128328,X'010a0306020302000002570128b52ffd20806d0200940355009a5592001c9a465500550099552400c79917490071995d92001c99742400c799d14900719945d5d0c9c5c2c0bcb9b7b53f0000000000000800b822c040206b6034301a183dd3ce05bc34035a28b52ffd205a4d0100d0087370686572652030313233343031323308737068657265203408040540c00106041c6040b01c01');
INSERT INTO chunk VALUES(1,1,10,518336685,X'010a03060203020014025c0128b52ffd2080950200c403009a5592001c9a4655140099552400c79917553b009955490071995d55b100995592001c9974551300d145d0c9c5c2c0bcb9b7b5b33f0000000000000900b822c040401ce83cd5b0602030101868005e34035a28b52ffd205a4d0100d0087370686572652031323334303132333408737068657265203008040540c00106041c6040b01c01');
INSERT INTO chunk VALUES(1,2,10,2253844678,X'010a03060203020028025b0128b52ffd20808d0200d4039a5592001c9a465514920099552400c79917553b24009955490071995d55b14900995592001c99745513d145c9c5c2c0bcb9b7b5b3b23f0000000000000800b822c040501ce8d85427c14dd0a600e634035a28b52ffd205a4d0100d0087370686572652032333430313233343008737068657265203108040540c00106041c6040b01c01');
INSERT INTO chunk VALUES(2,0,10,723128328,X'010a0306020302000002570128b52ffd20806d0200940355009a5592001c9a465500550099552400c79917490071995d92001c99742400c799d14900719945d5d0c9c5c2c0bcb9b7b53f0000000000000800b822c040206b6034301a183dd3ce05bc34035a28b52ffd205a4d0100d0087370686572652030313233343031323308737068657265203408040540c00106041c6040b01c01');
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
INSERT INTO job VALUES(1,'identify',1,X'','',0,3,1,3,NULL,1,NULL,0,'',1.0,'',X'726573756c74',NULL,NULL,NULL,'cell','j1','483b7e19aea3e8f8d834cb8a43949f58b3634e20ef914f79ad449a10a6917b6f',1700000000000000,1700000000000000,1700000000000000,1700000000000000,3);
INSERT INTO job VALUES(2,'identify',1,X'','',0,2,1,3,'7ad000720393ef2a6aa3c53a',1,87430000000,0,'',0.0,'',NULL,NULL,NULL,NULL,'cell','j2','483b7e19aea3e8f8d834cb8a43949f58b3634e20ef914f79ad449a10a6917b6f',1700000000000000,1700000000000000,1700086400000000,NULL,2);
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
INSERT INTO job_attempt VALUES(1,1,1,'7ad000720393ef2a6aa3c53a',1700000000000000,1700000000000000,'SUCCEEDED','');
INSERT INTO job_attempt VALUES(2,1,1,'7ad000720393ef2a6aa3c53a',1700086400000000,NULL,NULL,NULL);
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
INSERT INTO program VALUES(1,'nc','O1.nc',2,7,'943e9ca7fa8f32c8b4d71a0228614d7699164f446f5b2f2786779f174d95e968',NULL,'cell','p','48c07416c978e8ccdb19a21e581310e9ca6888bcf920ee8ffeed4d637cef9dfa',1700000000000000,1700000000000000);
CREATE TABLE program_part (
  program_id INTEGER NOT NULL REFERENCES program (id),
  first_byte INTEGER NOT NULL CHECK (first_byte >= 0),
  byte_count INTEGER NOT NULL CHECK (byte_count > 0),
  crc32c INTEGER NOT NULL,
  content BLOB NOT NULL,
  PRIMARY KEY (program_id, first_byte)
) STRICT, WITHOUT ROWID;
INSERT INTO program_part VALUES(1,0,7,1437742548,X'28b52ffd20073900004730312058310a');
CREATE TABLE job_program (
  job_id INTEGER NOT NULL REFERENCES job (id),
  position INTEGER NOT NULL,
  program_id INTEGER NOT NULL REFERENCES program (id),
  PRIMARY KEY (job_id, position)
) STRICT, WITHOUT ROWID;
INSERT INTO job_program VALUES(1,0,1);
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
INSERT INTO calibration VALUES(1,1,1,1,2,2,1,1700000000000000,'{"EA0B":1}','{}','{"rank":2}','test',2,NULL,NULL,NULL,2.9700000000000001953,'cell',1700000000000000,'cell',1700086400000000,NULL);
INSERT INTO calibration VALUES(2,1,2,1,1,1,NULL,1700086400000000,'{"EA0B":1}','{}','{"rank":2}','test',2,NULL,NULL,NULL,2.9700000000000001953,'cell',1700086400000000,NULL,NULL,NULL);
CREATE TABLE calibration_session (
  calibration_id INTEGER NOT NULL REFERENCES calibration (id),
  position INTEGER NOT NULL,
  session_id INTEGER NOT NULL REFERENCES session (id),
  PRIMARY KEY (calibration_id, position)
) STRICT, WITHOUT ROWID;
INSERT INTO calibration_session VALUES(1,0,1);
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
INSERT INTO estimate VALUES(1,'EA0B',1700000000000000,1,1,2,1,-101.20000000000000284,0.59999999999999997779);
INSERT INTO estimate VALUES(1,'EA0B',1700086400000000,2,1,2,1,-90.0,0.59999999999999997779);
INSERT INTO estimate VALUES(1,'EC0C',1700000000000000,1,2,2,0,NULL,NULL);
INSERT INTO estimate VALUES(1,'EC0C',1700086400000000,2,2,2,0,NULL,NULL);
INSERT INTO estimate VALUES(1,'EX0C',1700000000000000,1,0,1,1,53.100000000000001421,0.5);
INSERT INTO estimate VALUES(1,'EX0C',1700086400000000,2,0,1,1,53.100000000000001421,0.5);
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
INSERT INTO estimate_week VALUES(1,'EA0B',2810,2,2,0,-101.20000000000000284,-90.0,-191.19999999999998862,1700000000000000,1700086400000000,0.59999999999999997779,2);
INSERT INTO estimate_week VALUES(1,'EC0C',2810,2,0,2,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO estimate_week VALUES(1,'EX0C',2810,1,2,0,53.100000000000001421,53.100000000000001421,106.20000000000000283,1700000000000000,1700086400000000,0.5,2);
CREATE TABLE audit (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  at_utc_us INTEGER NOT NULL,
  principal TEXT NOT NULL,
  action TEXT NOT NULL,
  resource TEXT NOT NULL,
  outcome TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;
INSERT INTO audit VALUES(1,1700000000000000,'cell','machine.create','machines/mt','OK','');
INSERT INTO audit VALUES(2,1700000000000000,'cell','machine.update','machines/mt','OK','');
INSERT INTO audit VALUES(3,1700000000000000,'cell','calibration.create','calibrations/1','OK','');
INSERT INTO audit VALUES(4,1700086400000000,'cell','calibration.create','calibrations/2','OK','');
INSERT INTO audit VALUES(5,1700086400000000,'cell','calibration.approve','calibrations/1','OK','');
DELETE FROM sqlite_sequence;
INSERT INTO sqlite_sequence VALUES('audit',5);
INSERT INTO sqlite_sequence VALUES('session',2);
INSERT INTO sqlite_sequence VALUES('program',1);
INSERT INTO sqlite_sequence VALUES('job',2);
INSERT INTO sqlite_sequence VALUES('calibration',2);
CREATE UNIQUE INDEX session_by_request ON session (created_by, request_id) WHERE request_id IS NOT NULL;
CREATE INDEX session_by_machine ON session (machine_id, id);
CREATE INDEX session_open ON session (last_seen_at_utc_us) WHERE state = 1;
CREATE UNIQUE INDEX job_by_request ON job (created_by, request_id) WHERE request_id IS NOT NULL;
CREATE INDEX job_waiting ON job (priority DESC, id, run_after_utc_us) WHERE state = 1;
CREATE INDEX job_running ON job (owner, lease_until_steady_us) WHERE state = 2;
CREATE INDEX job_by_machine ON job (machine_id, id);
CREATE INDEX job_by_input ON job (input_hash, id) WHERE input_hash <> '';
CREATE INDEX program_open ON program (last_seen_at_utc_us) WHERE state = 1;
CREATE UNIQUE INDEX program_by_content ON program (sha256, kind) WHERE sha256 IS NOT NULL;
CREATE UNIQUE INDEX program_by_request ON program (created_by, request_id) WHERE request_id IS NOT NULL;
CREATE UNIQUE INDEX calibration_by_machine ON calibration (machine_id, version);
CREATE UNIQUE INDEX calibration_approved ON calibration (machine_id) WHERE state = 2;
CREATE UNIQUE INDEX calibration_by_job ON calibration (job_id) WHERE job_id IS NOT NULL;
CREATE TRIGGER audit_is_never_changed BEFORE UPDATE ON audit BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;
CREATE TRIGGER audit_is_never_deleted BEFORE DELETE ON audit BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;
CREATE TRIGGER chunk_is_never_changed BEFORE UPDATE ON chunk BEGIN SELECT RAISE (ABORT, 'a chunk is never changed'); END;
CREATE TRIGGER complete_session_keeps_its_chunks BEFORE DELETE ON chunk
WHEN (SELECT state FROM session WHERE id = OLD.session_id) = 2
BEGIN SELECT RAISE (ABORT, 'a complete session keeps its chunks'); END;
COMMIT;
PRAGMA application_id = 1098410355;
PRAGMA user_version = 1;
