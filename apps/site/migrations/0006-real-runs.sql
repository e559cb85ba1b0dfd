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
