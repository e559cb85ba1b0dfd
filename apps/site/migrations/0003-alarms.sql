-- SPDX-License-Identifier: Apache-2.0
-- Alarm statistics by month and rig, with the figures of ISA-18.2 (docs/alarm-response.md).
--
-- All times are seconds of a run (slots), which a step of the rig's clock does not change. The month of a second is that
-- of the start of its run plus the second, UTC, so a run that passes the end of a month counts in both. Imported runs
-- are left out: their rig is unknown.

-- The occurrences of alarms. An occurrence is announced unless it is the consequence of another alarm, or a warning that
-- is shelved. It is active until the alarm returns, the run is resumed, or the run ends. The acknowledgement is the next
-- one of the same alarm; a shelving replaces it. An alarm chatters if it is announced three times within a minute.
--
-- Each "later" window is in descending order, so that a run with many alarms is read once.
CREATE VIEW gyrotherm.alarm_occurrence AS
  WITH event AS (
    SELECT e.run, e.number, e.slot::bigint AS slot, e.kind, e.reaction, e.text,
           e.interlock || coalesce(' ' || nullif(e.channel, ''), '') AS alarm,
           e.kind = 'command' AND e.text ~ '^alarm [0-9]+ shelved for ' AS shelves,
           e.kind = 'command' AND e.text ~ '^alarm [0-9]+ unshelved' AS unshelves,
           e.kind = 'acknowledged' AND e.text ~ '^alarm [0-9]+( to [0-9]+)? acknowledged' AS acknowledges
    FROM gyrotherm.event e
    WHERE e.kind = 'resumed'
       OR e.interlock <> '' AND e.kind IN ('interlock', 'fault', 'recovered', 'acknowledged', 'command')
  ), followed AS (
    SELECT e.*, count(*) FILTER (WHERE shelves OR unshelves) OVER (PARTITION BY run, alarm ORDER BY number) AS phase,
           min(slot) FILTER (WHERE kind = 'recovered') OVER later AS returned,
           min(slot) FILTER (WHERE kind = 'resumed') OVER (PARTITION BY run ORDER BY number DESC) AS resumed,
           min(number) FILTER (WHERE acknowledges) OVER later AS acknowledgement,
           min(slot) FILTER (WHERE acknowledges) OVER later AS acknowledged,
           min(number) FILTER (WHERE shelves) OVER later AS shelving
    FROM event e
    WINDOW later AS (PARTITION BY run, alarm ORDER BY number DESC)
  ), judged AS (
    SELECT f.*, reaction = 'warn' AND bool_or(shelves) OVER (PARTITION BY run, alarm, phase) AS shelved,
           text LIKE '% [consequence of %]' AND reaction NOT IN ('hold', 'abort') AS suppressed
    FROM followed f
  ), occurrence AS (
    SELECT r.rig, r.simulated, r.started AT TIME ZONE 'UTC' AS started, j.run, j.number, j.slot, j.alarm,
           CASE j.reaction WHEN 'abort' THEN 'high' WHEN 'hold' THEN 'medium' WHEN 'suspend' THEN 'medium' ELSE 'low'
           END AS priority,
           coalesce(j.shelved, false) AS shelved, coalesce(j.suppressed, false) AS suppressed,
           NOT coalesce(j.shelved OR j.suppressed, false) AS announced,
           least(j.returned, j.resumed, r.last_slot) - j.slot AS active_s,
           CASE WHEN j.acknowledgement < coalesce(j.shelving, j.acknowledgement + 1) THEN j.acknowledged - j.slot
           END AS acknowledged_after
    FROM judged j JOIN gyrotherm.run r ON r.id = j.run
    WHERE j.kind IN ('interlock', 'fault') AND NOT r.imported
  )
  SELECT o.rig, o.simulated, date_trunc('month', o.started + o.slot * interval '1 second')::date AS month, o.run,
         o.number, o.slot, o.alarm, o.priority, o.shelved, o.suppressed, o.announced, o.active_s, o.acknowledged_after,
         o.announced AND coalesce(o.slot - lag(o.slot, 2) OVER same <= 60, false) AS chatters,
         o.slot / 600 AS period,
         date_trunc('month', o.started + o.slot / 600 * 600 * interval '1 second')::date AS period_month
  FROM occurrence o
  WINDOW same AS (PARTITION BY o.run, o.alarm, o.announced ORDER BY o.number);

-- One row for each month in which a rig ran or had an alarm. A period is ten minutes of a run, counted from its start.
-- `outside_isa_18_2` lists the figures that are outside the targets of the standard: on average one alarm in ten
-- minutes, at most ten in any ten minutes, more than ten (a flood) in less than 1 % of the time, none that chatters.
CREATE VIEW gyrotherm.v1_alarm_month AS
  WITH worked AS (
    SELECT r.rig, r.simulated, m.month::date AS month, sum(t.seconds) AS seconds
    FROM (SELECT rig, simulated, started AT TIME ZONE 'UTC' AS started,
                 started AT TIME ZONE 'UTC' + (last_slot::bigint + 1) * interval '1 second' AS until
          FROM gyrotherm.run WHERE NOT imported) r
    CROSS JOIN LATERAL generate_series(date_trunc('month', r.started), r.until, interval '1 month') AS m(month)
    CROSS JOIN LATERAL (SELECT extract(epoch FROM least(r.until, m.month + interval '1 month')
                                              - greatest(r.started, m.month)) AS seconds) t
    WHERE t.seconds > 0
    GROUP BY r.rig, r.simulated, m.month
  ), occurrence AS MATERIALIZED (
    SELECT * FROM gyrotherm.alarm_occurrence
  ), total AS (
    SELECT rig, simulated, month, count(*) FILTER (WHERE announced) AS alarms,
           count(*) FILTER (WHERE announced AND priority = 'high') AS high,
           count(*) FILTER (WHERE announced AND priority = 'medium') AS medium,
           count(*) FILTER (WHERE announced AND priority = 'low') AS low,
           count(*) FILTER (WHERE suppressed) AS suppressed, count(*) FILTER (WHERE shelved) AS shelved,
           count(DISTINCT (run, alarm)) FILTER (WHERE active_s > 86400) AS stale,
           count(DISTINCT (run, alarm)) FILTER (WHERE chatters) AS chattering,
           percentile_cont(0.5) WITHIN GROUP (ORDER BY acknowledged_after) FILTER (WHERE announced)
             AS acknowledged_after_s
    FROM occurrence GROUP BY rig, simulated, month
  ), flood AS (
    SELECT rig, simulated, month, max(alarms) AS most_in_10_min, count(*) FILTER (WHERE alarms > 10) AS floods
    FROM (SELECT rig, simulated, period_month AS month, run, period, count(*) AS alarms
          FROM occurrence WHERE announced GROUP BY rig, simulated, period_month, run, period) p
    GROUP BY rig, simulated, month
  ), frequent AS (
    SELECT DISTINCT ON (rig, simulated, month) rig, simulated, month, alarm AS most_frequent, count(*) AS times
    FROM occurrence WHERE announced GROUP BY rig, simulated, month, alarm
    ORDER BY rig, simulated, month, count(*) DESC, alarm
  ), shelving AS (
    SELECT r.rig, r.simulated,
           date_trunc('month', r.started AT TIME ZONE 'UTC' + e.slot * interval '1 second')::date AS month,
           count(*) AS shelvings
    FROM gyrotherm.event e JOIN gyrotherm.run r ON r.id = e.run
    WHERE NOT r.imported AND e.kind = 'command' AND e.interlock <> '' AND e.text ~ '^alarm [0-9]+ shelved for '
    GROUP BY 1, 2, 3
  ), rated AS (
    SELECT rig, simulated, month, seconds, coalesce(t.alarms, 0) AS alarms, coalesce(t.high, 0) AS high,
           coalesce(t.medium, 0) AS medium, coalesce(t.low, 0) AS low, coalesce(t.suppressed, 0) AS suppressed,
           coalesce(t.shelved, 0) AS shelved, coalesce(t.stale, 0) AS stale,
           coalesce(t.chattering, 0) AS chattering, t.acknowledged_after_s,
           coalesce(f.most_in_10_min, 0) AS most_in_10_min, coalesce(s.shelvings, 0) AS shelvings,
           q.most_frequent, 100.0 * q.times / t.alarms AS most_frequent_percent,
           coalesce(t.alarms, 0) * 600 / nullif(seconds, 0) AS per_10_min,
           least(100, 100 * 600 * coalesce(f.floods, 0) / nullif(seconds, 0)) AS flood_percent
    FROM worked w FULL JOIN total t USING (rig, simulated, month)
    LEFT JOIN flood f USING (rig, simulated, month)
    LEFT JOIN frequent q USING (rig, simulated, month)
    LEFT JOIN shelving s USING (rig, simulated, month)
  )
  SELECT rig, month, seconds / 3600 AS hours, alarms, high, medium, low, per_10_min, most_in_10_min, flood_percent,
         most_frequent, most_frequent_percent, stale, chattering, acknowledged_after_s, suppressed, shelved,
         shelvings,
         concat_ws(', ', CASE WHEN per_10_min > 1 THEN 'rate' END, CASE WHEN most_in_10_min > 10 THEN 'peak' END,
                   CASE WHEN flood_percent >= 1 THEN 'flood' END, CASE WHEN chattering > 0 THEN 'chattering' END)
           AS outside_isa_18_2,
         simulated
  FROM rated;

-- The announced alarms of each rig and month in the order of their numbers; rank 1 is the most frequent one.
CREATE VIEW gyrotherm.v1_alarm_rank AS
  SELECT rig, month,
         rank() OVER (PARTITION BY rig, simulated, month ORDER BY count(*) DESC) AS rank, alarm,
         (array_agg(priority ORDER BY array_position(ARRAY['high', 'medium', 'low'], priority)))[1] AS priority,
         count(*) AS alarms, 100.0 * count(*) / sum(count(*)) OVER (PARTITION BY rig, simulated, month) AS percent,
         bool_or(chatters) AS chatters, max(active_s) AS longest_s, simulated
  FROM gyrotherm.alarm_occurrence WHERE announced
  GROUP BY rig, simulated, month, alarm;

GRANT SELECT ON gyrotherm.alarm_occurrence, gyrotherm.v1_alarm_month, gyrotherm.v1_alarm_rank TO gyrotherm_analyst;
