-- oldest program: 22
-- The chunks of each 65,536 sessions stand in a table of their own, so that those of old sessions leave as a whole: by
-- numbers of sessions and not by months, as these stand in the key, which a time does not, and grow with time. Range N
-- is of sessions 65536 N to 65536 N + 65535, table chunk_range_N.
ALTER TABLE chunk RENAME TO chunk_before;
DROP TRIGGER chunk_is_never_changed ON chunk_before;
DROP TRIGGER chunk_is_never_emptied ON chunk_before;
DROP TRIGGER complete_session_keeps_its_chunks ON chunk_before;

CREATE TABLE chunk (
  session_id BIGINT NOT NULL,
  seq BIGINT NOT NULL CONSTRAINT chunk_seq_check CHECK (seq >= 0),
  reading_count BIGINT NOT NULL CONSTRAINT chunk_reading_count_check CHECK (reading_count > 0),
  crc32c BIGINT NOT NULL,
  content BYTEA NOT NULL,
  CONSTRAINT chunk_of_session FOREIGN KEY (session_id) REFERENCES session (id),
  CONSTRAINT chunk_key PRIMARY KEY (session_id, seq)
) PARTITION BY RANGE (session_id);
ALTER TABLE chunk ALTER COLUMN content SET STORAGE EXTERNAL;
CREATE TRIGGER chunk_is_never_changed BEFORE UPDATE ON chunk FOR EACH ROW EXECUTE FUNCTION refuse('a chunk is never changed');
CREATE TRIGGER chunk_is_never_emptied BEFORE TRUNCATE ON chunk EXECUTE FUNCTION refuse('a chunk is never changed');
CREATE TRIGGER complete_session_keeps_its_chunks BEFORE DELETE ON chunk FOR EACH ROW EXECUTE FUNCTION keep_chunks();

-- What is there becomes the range of the newest session, and reaches down to the first: nothing is copied. A session
-- that has no chunk yet has its range, too.
DO $$ DECLARE
  newest BIGINT := (SELECT max(id) / 65536 FROM session);
BEGIN
  IF newest IS NULL THEN
    DROP TABLE chunk_before;
  ELSE
    EXECUTE format('ALTER TABLE chunk_before RENAME TO %I', 'chunk_range_' || newest);
    EXECUTE format('ALTER TABLE chunk ATTACH PARTITION %I FOR VALUES FROM (MINVALUE) TO (%s)', 'chunk_range_' || newest,
      (newest + 1) * 65536);
    EXECUTE format('CREATE TRIGGER chunk_is_never_emptied BEFORE TRUNCATE ON %I EXECUTE FUNCTION refuse(%L)',
      'chunk_range_' || newest, 'a chunk is never changed');
  END IF;
END $$;

-- The first session of a range makes its table. To attach it, unlike to make it as a partition, keeps nobody from reading.
CREATE FUNCTION keep_range_of_session() RETURNS trigger LANGUAGE plpgsql AS $$ DECLARE
  range BIGINT := NEW.id / 65536;
  name TEXT := 'chunk_range_' || range;
BEGIN
  IF to_regclass(quote_ident(name)) IS NULL THEN
    BEGIN
      EXECUTE format('CREATE TABLE %I (LIKE chunk INCLUDING ALL)', name);
      EXECUTE format('ALTER TABLE chunk ATTACH PARTITION %I FOR VALUES FROM (%s) TO (%s)', name, range * 65536,
        (range + 1) * 65536);
      EXECUTE format('CREATE TRIGGER chunk_is_never_emptied BEFORE TRUNCATE ON %I EXECUTE FUNCTION refuse(%L)', name,
        'a chunk is never changed');
    EXCEPTION WHEN invalid_object_definition THEN
      NULL; -- a number that was taken before the migration: the range from before reaches over it
    END;
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER session_has_a_range AFTER INSERT ON session FOR EACH ROW EXECUTE FUNCTION keep_range_of_session();
