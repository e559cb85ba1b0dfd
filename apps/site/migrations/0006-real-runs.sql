-- SPDX-License-Identifier: Apache-2.0
-- Real, virtual and imported runs are told apart in further answers (docs/site.md#queries).

-- As in migration 1, but a run is silent by its age of run_now: the clock of a virtual rig does not count.
CREATE OR REPLACE VIEW gyrotherm.v1_attention AS
  SELECT r.id AS run, r.rig, r.started, r.profile, a.what, a.detail, r.simulated
  FROM gyrotherm.run_now r
  CROSS JOIN LATERAL (
    SELECT 'aborted' AS what, r.cause AS detail WHERE r.state IN ('aborting', 'aborted')
    UNION ALL
    SELECT 'alarm', (array_agg(e.text ORDER BY e.number DESC))[1] ||
                    CASE WHEN count(*) > 1 THEN format(' (%s times)', count(*)) ELSE '' END
    FROM gyrotherm.event e
    WHERE e.run = r.id AND e.kind IN ('interlock', 'fault') AND e.interlock <> '' AND NOT EXISTS (
      SELECT FROM gyrotherm.event k
      CROSS JOIN LATERAL regexp_match(k.text, '^alarm ([0-9]{1,18})(?: to ([0-9]{1,18}))? acknowledged') AS m
      WHERE k.run = r.id AND k.kind = 'acknowledged' AND m IS NOT NULL
        AND e.number BETWEEN m[1]::bigint AND coalesce(m[2], m[1])::bigint
        AND (m[2] IS NULL OR (k.interlock, coalesce(k.channel, '')) = (e.interlock, coalesce(e.channel, ''))))
    GROUP BY e.interlock, e.channel
    UNION ALL
    SELECT 'gaps', format('%s gaps, %s s without rows', count(*), sum(g.last - g.first + 1))
    FROM gyrotherm.gap g WHERE g.run = r.id HAVING count(*) > 0
    UNION ALL
    SELECT 'silent', format('%s; last row %s', r.state,
                            coalesce(to_char(gyrotherm.utc(r.last_utc_ns) AT TIME ZONE 'UTC',
                                             'YYYY-MM-DD"T"HH24:MI:SS"Z"'), 'none'))
    WHERE NOT r.finished AND r.state <> 'aborted' AND r.age > interval '10 minutes'
    UNION ALL
    SELECT 'more rows than its record', format('%s rows here, %s in the record', r.rows, r.rows_in_record)
    WHERE r.rows > r.rows_in_record
  ) a;

-- As in migration 1, but an imported run does not change the thermometers of the rig either: its rig is unknown.
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
    IF there.info <> kept OR there.rig <> a_rig THEN
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

-- Removes the thermometers of imported runs. Such a run may have replaced the thermometer of a real one.
DELETE FROM gyrotherm.thermometer t USING gyrotherm.run r WHERE r.id = t.run AND r.imported;
INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
SELECT DISTINCT ON (r.rig, c.name) r.rig, c.name, c.calibration->>'instrument', c.calibration->>'certificate',
       nullif(c.calibration->>'calibrated', '')::date, nullif(c.calibration->>'due', '')::date, r.id, r.started
FROM gyrotherm.run r JOIN gyrotherm.channel c ON c.run = r.id
WHERE NOT r.simulated AND NOT r.imported AND c.measures = 'temperature' AND c.calibration IS NOT NULL
ORDER BY r.rig, c.name, r.started DESC
ON CONFLICT DO NOTHING;

-- As in migration 1, but only runs of the kind that is shown are counted: real ones, or virtual ones of a rig without a
-- real run.
CREATE OR REPLACE VIEW gyrotherm.v1_rig AS
  SELECT g.name AS rig, g.owner, CASE WHEN r.finished THEN 'idle' ELSE r.state END AS state, r.profile, r.started,
         gyrotherm.utc(r.last_utc_ns) AS last_row,
         (SELECT string_agg(u.serial_number, ' ' ORDER BY u.label)
          FROM gyrotherm.run_unit u WHERE u.run = r.id) AS units,
         (SELECT count(*) FROM gyrotherm.run o WHERE o.rig = g.name AND o.simulated = r.simulated) AS runs,
         r.id AS run, r.simulated
  FROM gyrotherm.rig g
  LEFT JOIN LATERAL (
    SELECT * FROM gyrotherm.run o WHERE o.rig = g.name
    ORDER BY o.simulated, o.imported, o.started DESC LIMIT 1) r ON true;
