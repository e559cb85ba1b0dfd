-- SPDX-License-Identifier: Apache-2.0
-- What one rig says takes no answer away from the others. Before, a view failed for everybody as long as there was one
-- row with a number or a day that it could not reckon with: the place of no word, a gap without an end, a due date of
-- "soon", a result of 1e308. A month with such numbers could not be dropped, and a unit took no further calibration.

-- What is there already stays; what comes is refused. The tables are taken in the order in which the functions for rigs
-- take them, so that a rig that sends meanwhile waits for this, and this for no rig that waits for it.
-- A size that is none is nobody's: a view fails on it, and each change of its row would be refused.
UPDATE gyrotherm.run SET files = files #- '{0,bytes}'
  WHERE files->0 ? 'bytes' AND NOT coalesce(files->0->>'bytes' ~ '^[0-9]{1,18}$', false);
ALTER TABLE gyrotherm.run ADD CONSTRAINT run_file_has_a_size CHECK ((files->0->>'bytes')::bigint >= 0) NOT VALID;
ALTER TABLE gyrotherm.channel ADD CONSTRAINT channel_due_is_a_day
  CHECK (isfinite(nullif(calibration->>'due', '')::date)) NOT VALID;
ALTER TABLE gyrotherm.thermometer ADD CONSTRAINT thermometer_due_is_a_day
  CHECK (isfinite(calibrated) AND isfinite(due)) NOT VALID;
ALTER TABLE gyrotherm.gap ADD CONSTRAINT gap_lies_in_a_run CHECK (first >= 0 AND last <= 100000000) NOT VALID;
ALTER TABLE gyrotherm.calibration ADD CONSTRAINT calibration_is_of_a_day
  CHECK (isfinite(calibrated) AND isfinite(issued)) NOT VALID;
-- So that squares, differences and ratios of results are numbers too.
ALTER TABLE gyrotherm.calibration_result ADD CONSTRAINT result_is_a_number
  CHECK ((value = 0 OR abs(value) BETWEEN 1e-150 AND 1e100)
         AND (standard_uncertainty = 0 OR abs(standard_uncertainty) BETWEEN 1e-150 AND 1e100)
         AND (expanded_uncertainty = 0 OR abs(expanded_uncertainty) BETWEEN 1e-150 AND 1e100)) NOT VALID;

-- As before, but that a number which is the place of no word has none.
CREATE OR REPLACE VIEW gyrotherm.v1_sample AS
  SELECT s.run, s.slot, gyrotherm.utc(s.utc_ns) AS utc, c.name, n.value, c.unit,
         c.words[CASE WHEN n.value >= 0 AND n.value < cardinality(c.words) THEN n.value::integer + 1 END] AS word
  FROM gyrotherm.sample s
  CROSS JOIN LATERAL unnest(s.numbers) WITH ORDINALITY AS n(value, position)
  JOIN gyrotherm.channel c ON c.run = s.run AND c.position = n.position;

-- As before, but that a number which no mean can be made of counts for none.
CREATE OR REPLACE FUNCTION gyrotherm.drop_month(a_month date, detach boolean DEFAULT false) RETURNS bigint
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  first timestamptz := date_trunc('month', a_month::timestamptz);
  following timestamptz := first + interval '1 month';
  partition text := 'sample_' || to_char(first, 'YYYY_MM');
  runs bigint;
BEGIN
  IF to_regclass('gyrotherm.' || partition) IS NULL THEN RETURN 0; END IF;
  PERFORM FROM gyrotherm.run WHERE started >= first AND started < following ORDER BY id FOR UPDATE;
  IF EXISTS (SELECT FROM gyrotherm.run
             WHERE started >= first AND started < following AND NOT finished AND NOT dropped) THEN
    RAISE EXCEPTION 'a run that started in this month is not finished' USING ERRCODE = '55000',
      HINT = 'see gyrotherm.v1_attention; gyrotherm.give_up(run) takes one for ended that nobody will finish';
  END IF;
  INSERT INTO gyrotherm.sample_hour
    SELECT s.run, s.slot / 3600, n.position, count(*), avg(n.value), min(n.value), max(n.value)
    FROM gyrotherm.sample s
    CROSS JOIN LATERAL unnest(s.numbers) WITH ORDINALITY AS n(value, position)
    WHERE s.started >= first AND s.started < following AND abs(n.value) < 1e100
    GROUP BY s.run, s.slot / 3600, n.position
    ON CONFLICT DO NOTHING;
  UPDATE gyrotherm.run SET dropped = true WHERE started >= first AND started < following;
  GET DIAGNOSTICS runs = ROW_COUNT;
  EXECUTE format('ALTER TABLE gyrotherm.sample DETACH PARTITION gyrotherm.%I', partition);
  IF detach THEN
    EXECUTE format('ALTER TABLE gyrotherm.%I RENAME TO %I', partition, 'dropped_' || to_char(first, 'YYYY_MM'));
  ELSE
    EXECUTE format('DROP TABLE gyrotherm.%I', partition);
  END IF;
  RETURN runs;
END
$$;
