-- The call that created a job, as its caller traces it (W3C Trace Context): the job's lines in the log bear it too.

ALTER TABLE job ADD COLUMN trace TEXT NOT NULL DEFAULT '';
