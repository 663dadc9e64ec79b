-- Checksums of what moves machines. Rows that are there get theirs when the file is opened (server/storage/seal.h).

ALTER TABLE machine_revision ADD COLUMN sha256 TEXT NOT NULL DEFAULT '';
CREATE INDEX machine_revision_unsealed ON machine_revision (machine_id, revision) WHERE sha256 = '';

ALTER TABLE calibration ADD COLUMN checksum TEXT NOT NULL DEFAULT '';
CREATE INDEX calibration_unsealed ON calibration (id) WHERE checksum = '';
