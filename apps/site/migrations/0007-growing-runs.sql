-- SPDX-License-Identifier: Apache-2.0
-- Runs that end by themselves grow, a month is dropped more than once, and imported tables have no clock.

-- As in migration 6, but the segments of the same run may differ: add_segments() adds those that decisions add later.
CREATE OR REPLACE FUNCTION gyrotherm.add_run(a_run uuid, a_rig text, a_info jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' SET lock_timeout = '10s'
AS $$
DECLARE
  begun timestamptz := gyrotherm.utc((a_info->>'started_ns')::bigint);
  kept jsonb := a_info - 'channels';
  there gyrotherm.run;
  is_new boolean := false;
BEGIN
  IF begun IS NULL OR begun < 'epoch' OR begun >= '2117-01-01' THEN
    PERFORM gyrotherm.refuse('no run starts then');
  END IF;
  IF NOT EXISTS (SELECT FROM gyrotherm.run WHERE id = a_run) THEN
    PERFORM gyrotherm.end_stale();
    PERFORM gyrotherm.own_rig(a_rig);
    PERFORM gyrotherm.make_month(begun);
    INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info, heard)
    VALUES (a_run, a_rig, session_user, begun, a_info->>'profile', (a_info->>'simulated')::boolean,
            (a_info->>'imported')::boolean, kept, now())
    ON CONFLICT DO NOTHING;
    is_new := FOUND;
  END IF;
  IF NOT is_new THEN -- or another session was faster
    there := gyrotherm.own_run(a_run);
    IF there.info - 'segments' <> kept - 'segments' OR there.rig <> a_rig THEN
      PERFORM gyrotherm.refuse('the run that is there is another one');
    END IF;
    RETURN;
  END IF;
  INSERT INTO gyrotherm.channel(run, position, name, unit, measures, unit_under_test, words, calibration)
  SELECT a_run, c.position, c.value->>'name', c.value->>'unit', c.value->>'measures', c.value->>'unit_under_test',
         CASE WHEN c.value ? 'words' THEN ARRAY(SELECT jsonb_array_elements_text(c.value->'words')) END,
         c.value->'calibration'
  FROM jsonb_array_elements(a_info->'channels') WITH ORDINALITY AS c(value, position);
  INSERT INTO gyrotherm.run_unit(run, label, serial_number, model)
  SELECT a_run, u->>'label', u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '';
  IF (a_info->>'simulated')::boolean OR (a_info->>'imported')::boolean THEN RETURN; END IF;
  INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
  SELECT a_rig, c->>'name', c->'calibration'->>'instrument', c->'calibration'->>'certificate',
         nullif(c->'calibration'->>'calibrated', '')::date, nullif(c->'calibration'->>'due', '')::date, a_run, begun
  FROM jsonb_array_elements(a_info->'channels') c WHERE c->>'measures' = 'temperature' AND c ? 'calibration'
  ON CONFLICT (rig, name) DO UPDATE SET instrument = EXCLUDED.instrument, certificate = EXCLUDED.certificate,
    calibrated = EXCLUDED.calibrated, due = EXCLUDED.due, run = EXCLUDED.run, started = EXCLUDED.started
  WHERE gyrotherm.thermometer.started < EXCLUDED.started;
END
$$;

-- Replaces the segments of a run: [{"name", …}]. Those that are there must be the first ones. Fewer segments that are
-- equal change nothing. Returns the number of the segments.
CREATE FUNCTION gyrotherm.add_segments(a_run uuid, a_segments jsonb) RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
  there jsonb := coalesce(to_run.info->'segments', '[]');
  common integer;
BEGIN
  IF jsonb_typeof(a_segments) IS DISTINCT FROM 'array' OR jsonb_typeof(there) <> 'array'
     OR octet_length(a_segments::text) > 10000000 THEN
    PERFORM gyrotherm.refuse('the segments are not a list');
  END IF;
  common := least(jsonb_array_length(there), jsonb_array_length(a_segments));
  IF EXISTS (
    SELECT FROM jsonb_array_elements(there) WITH ORDINALITY AS t(value, n)
    JOIN jsonb_array_elements(a_segments) WITH ORDINALITY AS s(value, n) USING (n)
    WHERE n <= common AND t.value <> s.value
  ) THEN
    PERFORM gyrotherm.refuse('a segment that is there is another one');
  END IF;
  IF jsonb_array_length(a_segments) <= common THEN RETURN jsonb_array_length(there); END IF;
  IF to_run.finished THEN PERFORM gyrotherm.refuse('the run is finished'); END IF;
  UPDATE gyrotherm.run SET info = jsonb_set(info, '{segments}', a_segments) WHERE id = a_run;
  RETURN jsonb_array_length(a_segments);
END
$$;
REVOKE ALL ON FUNCTION gyrotherm.add_segments(uuid, jsonb) FROM PUBLIC;
GRANT EXECUTE ON FUNCTION gyrotherm.add_segments(uuid, jsonb) TO gyrotherm_rig;

-- As in migration 1, but with `detach` the partition gets an unused name: dropped_YYYY_MM, or dropped_YYYY_MM_2 and so
-- on if the month was dropped before.
CREATE OR REPLACE FUNCTION gyrotherm.drop_month(a_month date, detach boolean DEFAULT false) RETURNS bigint
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  first timestamptz := date_trunc('month', a_month::timestamptz);
  following timestamptz := first + interval '1 month';
  partition text := 'sample_' || to_char(first, 'YYYY_MM');
  base text := 'dropped_' || to_char(first, 'YYYY_MM');
  unused text := base;
  tried integer := 1;
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
    WHILE to_regclass(format('gyrotherm.%I', unused)) IS NOT NULL LOOP
      tried := tried + 1;
      unused := base || '_' || tried;
    END LOOP;
    EXECUTE format('ALTER TABLE gyrotherm.%I RENAME TO %I', partition, unused);
  ELSE
    EXECUTE format('DROP TABLE gyrotherm.%I', partition);
  END IF;
  RETURN runs;
END
$$;

-- As in migration 1, but an event without a time, as imported tables have it, has none here.
CREATE OR REPLACE VIEW gyrotherm.v1_event AS
  SELECT run, number, slot, gyrotherm.utc(nullif(utc_ns, 0)) AS utc, kind, interlock, reaction, segment,
         channel, text
  FROM gyrotherm.event;

-- As in migration 1, but the times of an imported table do not count either.
CREATE OR REPLACE VIEW gyrotherm.run_now AS
  SELECT *, greatest(now() - heard,
                     CASE WHEN NOT simulated AND NOT imported
                          THEN now() - coalesce(gyrotherm.utc(last_utc_ns), started) END,
                     interval '0') AS age
  FROM gyrotherm.run;
