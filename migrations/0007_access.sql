-- Who may do what: people and cells, their tokens and roles, the groups of machines. Programs know who may see them.

CREATE TABLE principal (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL UNIQUE,
  note TEXT NOT NULL,
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  revoked_at_utc_us INTEGER
) STRICT;

CREATE TABLE token (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  principal_id INTEGER NOT NULL REFERENCES principal (id),
  sha256 TEXT NOT NULL UNIQUE,
  note TEXT NOT NULL,
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  expires_at_utc_us INTEGER,
  last_used_at_utc_us INTEGER,
  revoked_at_utc_us INTEGER
) STRICT;
CREATE INDEX token_of_principal ON token (principal_id, id);

CREATE TABLE principal_role (
  principal_id INTEGER NOT NULL REFERENCES principal (id),
  role INTEGER NOT NULL CHECK (role BETWEEN 1 AND 5),
  scope INTEGER NOT NULL CHECK (scope BETWEEN 1 AND 3),
  scope_name TEXT NOT NULL CHECK ((scope_name = '') = (scope = 1)),
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  PRIMARY KEY (principal_id, role, scope, scope_name)
) STRICT, WITHOUT ROWID;

CREATE TABLE machine_group (
  name TEXT NOT NULL,
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  PRIMARY KEY (name, machine_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX group_of_machine ON machine_group (machine_id, name);

ALTER TABLE machine ADD COLUMN four_eyes INTEGER NOT NULL DEFAULT 0 CHECK (four_eyes IN (0, 1));

-- A program is seen by those who sent it, and by those who see a machine that it was rewritten for.
CREATE TABLE program_holder (
  holder TEXT NOT NULL,
  program_id INTEGER NOT NULL REFERENCES program (id),
  PRIMARY KEY (holder, program_id)
) STRICT, WITHOUT ROWID;
INSERT INTO program_holder (holder, program_id) SELECT created_by, id FROM program WHERE state <> 3;
INSERT OR IGNORE INTO program_holder (holder, program_id)
  SELECT created_by, same_as FROM program WHERE state = 3;

CREATE TABLE program_machine (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  program_id INTEGER NOT NULL REFERENCES program (id),
  PRIMARY KEY (machine_id, program_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX machine_of_program ON program_machine (program_id, machine_id);
INSERT OR IGNORE INTO program_machine (machine_id, program_id)
  SELECT j.machine_id, p.program_id FROM job_program AS p JOIN job AS j ON j.id = p.job_id WHERE j.machine_id IS NOT NULL;
