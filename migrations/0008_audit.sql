-- The audit says from where, what was before and after, and is a chain: each row's hash covers the row before it. Rows that
-- are there get their hash when the file is opened (server/storage/audit.h).

ALTER TABLE audit ADD COLUMN peer TEXT NOT NULL DEFAULT '';
ALTER TABLE audit ADD COLUMN was TEXT NOT NULL DEFAULT '';
ALTER TABLE audit ADD COLUMN became TEXT NOT NULL DEFAULT '';

CREATE TABLE audit_chain (
  audit_id INTEGER PRIMARY KEY REFERENCES audit (id),
  sha256 TEXT NOT NULL
) STRICT;

-- Where the chain begins: the last row that retention has removed, and its hash.
CREATE TABLE audit_anchor (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  audit_id INTEGER NOT NULL CHECK (audit_id >= 0),
  sha256 TEXT NOT NULL,
  is_chained INTEGER NOT NULL CHECK (is_chained IN (0, 1))
) STRICT;
INSERT INTO audit_anchor (id, audit_id, sha256, is_chained) VALUES (1, 0, '', 0);
CREATE TRIGGER audit_anchor_only_moves_on BEFORE UPDATE ON audit_anchor
WHEN NEW.audit_id < OLD.audit_id OR NEW.is_chained < OLD.is_chained
BEGIN SELECT RAISE (ABORT, 'the anchor of the audit only moves on'); END;
CREATE TRIGGER audit_anchor_is_never_deleted BEFORE DELETE ON audit_anchor
BEGIN SELECT RAISE (ABORT, 'the anchor of the audit stays'); END;

DROP TRIGGER audit_is_never_deleted;
CREATE TRIGGER audit_is_never_deleted BEFORE DELETE ON audit
WHEN OLD.id > (SELECT audit_id FROM audit_anchor WHERE id = 1)
BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;
CREATE TRIGGER audit_chain_is_never_changed BEFORE UPDATE ON audit_chain
BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;
CREATE TRIGGER audit_chain_is_never_deleted BEFORE DELETE ON audit_chain
WHEN OLD.audit_id > (SELECT audit_id FROM audit_anchor WHERE id = 1)
BEGIN SELECT RAISE (ABORT, 'audit is append-only'); END;

CREATE INDEX audit_by_time ON audit (at_utc_us, id);
CREATE INDEX audit_by_principal ON audit (principal, at_utc_us, id);
CREATE INDEX audit_by_resource ON audit (resource, at_utc_us, id);

-- Once a day of up time: the newest rows then. What is removed by age is at least so old, whatever a wall clock says.
CREATE TABLE age_mark (
  up_us INTEGER PRIMARY KEY CHECK (up_us >= 0),
  audit_id INTEGER NOT NULL,
  session_id INTEGER NOT NULL
) STRICT;
