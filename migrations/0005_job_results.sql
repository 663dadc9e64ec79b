-- Checksums of what jobs have found. Results that are there get theirs when the file is opened (server/storage/seal.h).

ALTER TABLE job ADD COLUMN result_sha256 TEXT NOT NULL DEFAULT '';
CREATE INDEX job_unsealed ON job (id) WHERE state = 3 AND result_sha256 = '';
