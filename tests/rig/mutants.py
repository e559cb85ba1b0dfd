#!/usr/bin/env python3
"""Breaks one rule of safety at a time and shows that a named test notices.

    tests/rig/mutants.py BUILD [PART-OF-A-NAME]

BUILD is a folder built with Ninja, with sequencer_test, rig_test and faults_test in it. Each mutant is one edit of one
line of one source: it is compiled from a copy, linked in front of the libraries of the build, and the test that holds
the rule must fail; before, the same test must pass unchanged. Exit code 1 if a mutant survives or its line is not there
any more.
"""
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def shown_by(name):
    return "Interlocks/EachInterlock.BrokenAloneActsAloneAsItsTablePromises/" + name


# name, source, what it says, what the mutant says, test program, test that must fail
MUTANTS = [
    ("abort is not latched", "sequencer/procedure.cpp",
     "Procedure step(const ProcedureLimits&, const Aborted& state, const Happening&) { return state; }",
     "Procedure step(const ProcedureLimits&, const Aborted&, const Happening&) { return Execute{}; }",
     "sequencer_test", "Procedure.AnAbortIsLatchedAndWaitsForTheChamber"),
    ("abort does not wait for the chamber", "sequencer/procedure.cpp",
     "if (!now.safe_confirmed) return state;", "",
     "sequencer_test", "Procedure.AnAbortIsLatchedAndWaitsForTheChamber"),
    ("a suspension has no limit", "sequencer/procedure.cpp",
     "if (state.since >= limits.longest_suspended)", "if (false)",
     "sequencer_test", "Procedure.NothingLastsLongerThanItsLimit"),
    ("a hold has no limit", "sequencer/procedure.cpp",
     "if (state.since >= limits.longest_held)", "if (false)",
     "sequencer_test", "Procedure.NothingLastsLongerThanItsLimit"),
    ("a return has no limit", "sequencer/procedure.cpp",
     "if (state.since >= limits.longest_return)", "if (false)",
     "sequencer_test", "Procedure.NothingLastsLongerThanItsLimit"),
    ("no delay before going on", "sequencer/procedure.cpp",
     "return asked || state.clear >= limits.resume_delay ?", "return asked || !stands ?",
     "sequencer_test", "Procedure.ASuspensionEndsByItselfAfterItsCauseIsGoneForAWhile"),
    ("the delay does not begin anew", "sequencer/procedure.cpp",
     "state.clear = stands ? Duration{} : state.clear + now.elapsed;", "state.clear += stands ? Duration{} : now.elapsed;",
     "sequencer_test", "Procedure.ASuspensionEndsByItselfAfterItsCauseIsGoneForAWhile"),
    ("a hold ends by itself", "sequencer/procedure.cpp",
     "if (now.command != OperatorCommand::resume || now.verdict.reaction == Reaction::hold) return state;",
     "if (now.verdict.reaction == Reaction::hold) return state;",
     "sequencer_test", "Procedure.AHoldEndsByTheOperatorAlone"),
    ("a hold is left while its cause stands", "sequencer/procedure.cpp",
     "if (now.command != OperatorCommand::resume || now.verdict.reaction == Reaction::hold) return state;",
     "if (now.command != OperatorCommand::resume) return state;",
     "sequencer_test", "Procedure.AHoldEndsByTheOperatorAlone"),
    ("an interlock's abort is only a stop", "sequencer/procedure.cpp",
     "if (now.verdict.reaction == Reaction::abort) return Aborting{now.verdict.cause, {}, false};",
     "if (now.verdict.reaction == Reaction::abort) return Stopped{now.verdict.cause};",
     "sequencer_test", "Procedure.AnAbortIsLatchedAndWaitsForTheChamber"),
    ("a pause outranks an abort", "sequencer/procedure.cpp",
     "if (now.verdict.reaction == Reaction::abort) return",
     "if (now.verdict.reaction == Reaction::abort && !now.command) return",
     "sequencer_test", "Procedure.TheMostSevereWins"),
    ("set points are sent when it is over", "sequencer/procedure.cpp",
     "return state == RunState::execute || state == RunState::suspended", "return state == RunState::complete || state == RunState::execute || state == RunState::suspended",
     "sequencer_test", "Procedure.NothingIsCommandedOnceItIsOver"),
    ("any state may follow any other", "sequencer/procedure.cpp",
     "if (from == to) return true;", "return true;",
     "sequencer_test", "Procedure.StatesChangeAlongTheTableAlone"),
    ("a soak counts outside its band", "sequencer/machine.cpp",
     "if (soaks) hold.soaked += seen.elapsed;", "hold.soaked += seen.elapsed;",
     "sequencer_test", "Soak.CountsOnlyInsideTheBand"),
    ("a segment has no deadline", "sequencer/machine.cpp",
     "if (hold.elapsed > segment.deadline)", "if (false)",
     "sequencer_test", "Soak.IsOverdueAfterItsDeadlineAndStaysSo"),
    ("one sample is enough for a limit", "rig/interlocks.cpp",
     "case Cause::thermometer_limit: return {{}, limits.confirming_samples};", "case Cause::thermometer_limit: return {};",
     "rig_test", "Interlocks.AbortAtTheSecondSampleBeyondALimit"),
    ("the air has no limits", "rig/interlock_checks.cpp",
     "if (!(air >= limits_.air_lowest && air <= limits_.air_highest))", "if (false)",
     "rig_test", "Interlocks.AbortAtTheSecondSampleBeyondALimit"),
    ("thermometers have no limits of their own", "rig/interlock_checks.cpp",
     "const auto own = i < limits_.thermometers.size()", "const auto own = false",
     "rig_test", "Cause.EachThermometerMayHaveLimitsOfItsOwn"),
    ("a lost chamber is waited for", "rig/interlocks.cpp",
     "if (finding.grave || (lost && stands >= *lost)) return Reaction::abort;", "if (finding.grave) return Reaction::abort;",
     "rig_test", "Interlocks.SuspendWhenTheChamberIsSilentAndAbortWhenItIsLost"),
    ("the milder reaction wins", "rig/interlocks.cpp",
     "if (reaction > judged.verdict.reaction)", "if (reaction < judged.verdict.reaction || judged.verdict.cause.empty())",
     "rig_test", "Interlocks.TheMostSevereReactionWins"),
    ("an alarm is told again and again", "rig/interlocks.cpp",
     "if (!std::exchange(memory.raised, true))", "memory.raised = true;\n  if (true)",
     "rig_test", "Cause.OneAlarmUntilItIsOver"),
    ("an alarm is over at once", "rig/interlocks.cpp",
     "if (memory.raised && memory.gone >= limits.clear_after)", "if (memory.raised)",
     "rig_test", "Cause.OneAlarmUntilItIsOver"),
    ("an open door is nothing", "rig/interlock_checks.cpp",
     "case ChamberActivity::door_open: return found(", "case ChamberActivity::door_open: return; found(",
     "rig_test", "BrokenRig.AnOpenDoorStopsTheClockAndShortensNoSoak"),
    ("the chamber's alarms are nothing", "rig/interlock_checks.cpp",
     "if (chamber.must_stop)", "if (false)",
     "rig_test", "Interlocks.DoWhatTheChamberItselfAsksFor"),
    ("a foreign set point is not noticed", "rig/interlock_checks.cpp",
     "if (!off && !other) return;", "if (!off) return;",
     "rig_test", "Cause.AForeignSetPointIsFoundAtTheSecondPoll"),
    ("a chamber switched off is not noticed", "rig/interlock_checks.cpp",
     "if (!off && !other) return;", "if (!other) return;",
     "rig_test", "Cause.ASwitchedOffChamberSuspends"),
    ("a restart is taken for a stranger", "rig/interlock_checks.cpp",
     "if (was_silent || stands(Cause::restarted))", "if (false)",
     "rig_test", "Cause.AChamberThatComesBackOtherwiseWasRestarted"),
    ("set points not taken are not noticed", "rig/interlock_checks.cpp",
     "if (around_.refusals >= kRefusals)", "if (false)",
     "rig_test", "Cause.ThreeSetPointsNotTakenSuspend"),
    ("air that does not follow is not noticed", "rig/interlock_checks.cpp",
     "if (abs(air - *memory_.expected) <= band) return;", "return;",
     "rig_test", "Cause.AirThatDoesNotFollowSuspendsAfterFiveMinutes"),
    ("the chamber's sensor is believed", "rig/interlock_checks.cpp",
     "if (abs(memory_.air_jumped) > limits_.chamber_disagreement)", "if (false)",
     "rig_test", "Cause.AChamberSensorThatJumpsAbortsThoughItsControllerBringsTheReadingBack"),
    ("a sleep of the machine is nothing", "rig/interlock_checks.cpp",
     "if (around_.missed > around_.longest_missed)", "if (false)",
     "rig_test", "Cause.AMachineThatSleptHolds"),
    ("a stuck thermometer is not noticed", "rig/interlock_checks.cpp",
     "if (trend.unchanged_samples() >= kStuckSamples &&", "if (false &&",
     "rig_test", "Cause.AStuckThermometerWarnsWhileTheOthersMove"),
    ("lost thermometers are not counted", "rig/interlock_checks.cpp",
     "if (answer < needed)", "if (answer == 0)",
     "rig_test", "Cause.FewerThermometersThanNeededSuspendWithinTenSeconds"),
    ("a record that falls behind is not noticed", "rig/interlock_checks.cpp",
     "else if (around_.backlog > limits_.backlog)", "else if (false)",
     "rig_test", "Cause.ARecordThatIsBehindWarnsUnlessThePolicySaysMore"),
    ("a step of the wall clock is not noticed", "rig/interlock_checks.cpp",
     "if (std::chrono::abs(step) > kWallStep)", "if (false)",
     "rig_test", "Cause.AStepOfTheWallClockWarnsAndStopsNothing"),
    ("limits may be switched off by the policy", "rig/cause.cpp",
     "{Cause::thermometer_limit, \"thermometer_limit\", Reaction::abort, false},",
     "{Cause::thermometer_limit, \"thermometer_limit\", Reaction::abort, true},",
     "rig_test", "Cause.WhatWouldDamageTheArticleCannotBeChosen"),
    ("the set point jumps", "rig/set_point_path.cpp",
     "if (abs(way) <= reach) return goal;", "return goal;",
     "rig_test", "BrokenRig.ARunThatBeginsElsewhereGoesThereByARampAndItsClockWaits"),
    ("a restarted chamber is sent back at once", "rig/experiment.cpp",
     "path_.begin_at(chamber.air);", "path_.begin_at(command(profile_, state_));",
     "rig_test", "BrokenRig.ARestartedChamberIsRampedBackFromWhereTheAirIs"),
    ("a stranger is fought", "rig/experiment.cpp",
     "if (stands(Cause::restarted) || std::exchange(taking_over_, false))",
     "if (stands(Cause::restarted) || stands(Cause::foreign_set_point))",
     "rig_test", "BrokenRig.AForeignSetPointIsNotFought"),
    ("the profile's clock runs while suspended", "rig/experiment.cpp",
     "if (run_state() != RunState::execute) return;", "if (run_state() == RunState::complete) return;",
     "rig_test", "BrokenRig.AnOpenDoorStopsTheClockAndShortensNoSoak"),
    ("the profile's clock runs through a gap", "rig/experiment.cpp",
     "if (watch_) state_ = next(profile_,", "state_ = next(profile_,",
     "rig_test", "BrokenRig.InALateSecondTheClockStandsAndTheSetPointDoesNotJump"),
    ("the run ends before the chamber is safe", "rig/safe_sequence.cpp",
     "confirmed_ = std::isnan(shown.value) || abs(shown - target_) <= tolerance_;", "confirmed_ = true;",
     "rig_test", "BrokenRig.ASafeSetPointThatIsNotKeptIsSentAgain"),
    ("safe waits for the line's rest", "rig/safe_sequence.cpp",
     "if (at_once) insisted_ = at;", "return std::nullopt;",
     "rig_test", "BrokenRig.AnArticleBeyondItsLimitMakesSafeAndTheRunEndsWhenTheChamberHasShownIt"),
    ("safe does not switch off", "rig/safe_sequence.cpp",
     "if (off_ && !switched_) {", "if (false) {",
     "rig_test", "BrokenRig.SafeMaySwitchTheChamberOffToo"),
    ("the operator is not told", "rig/safe_sequence.cpp",
     "if (done || !is_due(told_, at, kTellEvery)) return std::nullopt;", "return std::nullopt;",
     "rig_test", "BrokenRig.AChamberThatCannotBeMadeSafeIsTriedUntilItCanAndTheOperatorIsToldOnceAMinute"),
    ("a broken law goes unpunished", "rig/set_point_path.cpp",
     "ensure(target >= limits_.lowest && target <= limits_.highest,", "ensure(true,",
     "rig_test", "BrokenRigDeathTest.ALawOfSafetyThatIsBrokenEndsTheProcess"),
    ("resume after any gap", "rig/resume_rule.cpp",
     "if (stood.down > kLongestUnattended)", "if (false)",
     "rig_test", "ResumeRule.AsksAfterALongGapWhereverTheAirIs"),
    ("resume on the hostile side", "rig/resume_rule.cpp",
     "if (air_now < lowest || air_now > highest)", "if (false)",
     "rig_test", "ResumeRule.AsksAfterADriftBeyondTheSegmentOnTheHostileSide"),
    ("resume what an interlock ended", "rig/resume_rule.cpp",
     "if (stood.aborted)", "if (false)",
     "rig_test", "ResumeRule.AsksWhatAnInterlockEndedOrAnOperatorHeld"),
    ("resume without stabilising", "rig/resume_rule.cpp",
     "if (abs(air_now - *stood.air) > kResumeBand)", "if (false)",
     "rig_test", "ResumeRule.StabilisesAgainAfterADriftToTheMildSide"),
    ("a set point outruns the ramp limit unpunished", "rig/set_point_path.cpp",
     "ensure(begins_ || abs(target - base_) <=", "ensure(true || abs(target - base_) <=",
     "rig_test", "BrokenRigDeathTest.ASetPointFasterThanTheRampLimitEndsTheProcess"),
    ("a soak counts without its dwell", "sequencer/machine.cpp",
     "|| inside_before < segment.soak_dwell", "",
     "sequencer_test", "Soak.CountsOnlyAfterItsDwellInTheBandWithoutLeavingIt"),
    ("the dwell does not begin anew", "sequencer/machine.cpp",
     "hold.inside = inside_band(segment, seen.air) ? hold.inside + seen.elapsed : Duration::zero();",
     "hold.inside += inside_band(segment, seen.air) ? seen.elapsed : Duration::zero();",
     "sequencer_test", "Soak.CountsOnlyAfterItsDwellInTheBandWithoutLeavingIt"),
    ("a soak counts at any slope", "sequencer/machine.cpp",
     "return seen.slope && std::abs(seen.slope->value) <= segment.soak_slope.value;", "return seen.slope.has_value();",
     "sequencer_test", "Soak.CountsOnlyWhileItsSensorStandsStill"),
    ("a soak counts at a slope that is not known", "sequencer/machine.cpp",
     "return seen.slope && std::abs", "return !seen.slope || std::abs",
     "sequencer_test", "Soak.CountsOnlyWhileItsSensorStandsStill"),
    ("a record that loses rows is not noticed", "rig/interlock_checks.cpp",
     "if (around_.rows_dropped)", "if (false)",
     "rig_test", "Cause.ARecordThatIsBehindWarnsUnlessThePolicySaysMore"),
    ("an emergency stop is nothing", "rig/interlock_checks.cpp",
     "case ChamberActivity::emergency_stop:", "case ChamberActivity::emergency_stop: return;",
     "faults_test", shown_by("AnEmergencyStop")),
    ("a lost supply is nothing", "rig/interlock_checks.cpp",
     "case ChamberActivity::power_failure: return found(", "case ChamberActivity::power_failure: return; found(",
     "faults_test", shown_by("TheSupplyLost")),
    ("a silent gyro is nothing", "rig/interlock_checks.cpp",
     "if (!sample_.gyro.value) found(", "if (false) found(",
     "faults_test", shown_by("TheGyrosLineCut")),
    ("a passed deadline is nothing", "rig/interlock_checks.cpp",
     "if (sample_.progress.phase == Phase::overdue)", "if (false)",
     "faults_test", shown_by("ASoakThatNeverCounts")),
    ("a program that ended is nothing", "rig/interlock_checks.cpp",
     "if (!around_.program.empty())", "if (false)",
     "faults_test", shown_by("AProgramEndedAtThePanel")),
    ("air that changes too fast is nothing", "rig/interlock_checks.cpp",
     "std::abs(rate->value) > limits_.air_fastest.value)", "std::abs(rate->value) > 1e9)",
     "faults_test", shown_by("ADoorThatNoSwitchTells")),
    ("an article that changes too fast is nothing", "rig/interlock_checks.cpp",
     "rate && std::abs(rate->value) > limits_.thermometers_fastest.value)", "false)",
     "faults_test", shown_by("HeatersStuckWarmTheArticle")),
    ("a thermometer apart from the others is nothing", "rig/interlock_checks.cpp",
     "if (abs(*value - *others) > limits_.disagreement)", "if (false)",
     "faults_test", shown_by("AThermometerApartFromTheOthers")),
    ("a thermometer in the air is not asked", "rig/interlock_checks.cpp",
     "if (!others || abs(air - *others) <= limits_.chamber_disagreement) return;", "return;",
     "faults_test", shown_by("TheChambersSensorApartFromAThermometerInTheAir")),
    ("air that moves is taken for a jump", "rig/interlock_checks.cpp",
     "if (abs(*air - *before) > fastest * unseen)", "if (true)",
     "rig_test", "Cause.AirThatLeavesThroughTheDoorIsNoContradiction"),
    ("air near a limit is only waited for", "rig/interlock_checks.cpp",
     "          near_a_limit);", "          near_a_limit && false);",
     "faults_test", shown_by("HeatersWithoutPowerNearALimit")),
    ("lost rows are an alarm for ever", "acquisition/background_store.cpp",
     "desk.dropped_before = desk.backlog.dropped();", "",
     "faults_test", shown_by("AFullDiskForLongerThanTheMemoryHolds")),
]

# What the rig file says of these is what holds.
for key in ("longest_suspended", "longest_held", "longest_return", "resume_delay", "clear_after", "suspend_after",
            "chamber_lost", "thermometers_lost", "gyro_lost", "chamber_lag", "follow_time", "backlog"):
    MUTANTS.append((f"the rig file's {key} is not heeded", "rig/limits_table.cpp",
                    f"limits.{key} = read_time(", "(void)read_time(",
                    "rig_test", "RigFile.EachLimitIsTheOneThatTheFileSays"))

# The reaction of each cause: milder, or for a warning severer, is noticed.
POLICY = {
    "air_limit": ("abort", "hold", "HeatersStuckBeyondTheAirsLimit"),
    "thermometer_limit": ("abort", "hold", "AThermometerBeyondItsLimit"),
    "chamber_alarm": ("abort", "hold", "ATrippedLimiter"),
    "emergency_stop": ("abort", "hold", "AnEmergencyStop"),
    "deadline": ("abort", "hold", "ASoakThatNeverCounts"),
    "program": ("abort", "hold", "AProgramEndedAtThePanel"),
    "chamber_sensor": ("abort", "hold", "TheChambersSensorDetached"),
    "chamber_silent": ("suspend", "warn", "TheChambersLineCut"),
    "thermometers_lost": ("suspend", "warn", "AThermometersLineCut"),
    "gyro_silent": ("suspend", "warn", "TheGyrosLineCut"),
    "door": ("suspend", "warn", "AnOpenDoor"),
    "supply": ("suspend", "warn", "TheSupplyLost"),
    "air_rate": ("suspend", "warn", "ADoorThatNoSwitchTells"),
    "thermometer_rate": ("suspend", "warn", "HeatersStuckWarmTheArticle"),
    "following": ("suspend", "warn", "HeatersWithoutPower"),
    "foreign_set_point": ("suspend", "warn", "ASetPointFromThePanel"),
    "restarted": ("suspend", "warn", "APowerCutOfTheChamber"),
    "not_taken": ("suspend", "warn", "SetPointsAcknowledgedAndNotApplied"),
    "slept": ("hold", "suspend", "AMachineThatSlept"),
    "storage": ("warn", "suspend", "AFullDisk"),
    "disagreement": ("warn", "suspend", "AThermometerApartFromTheOthers"),
    "stuck": ("warn", "suspend", "AFrozenThermometer"),
    "wall_clock": ("warn", "suspend", "AStepOfTheTimeOfDay"),
}
ALWAYS = ("air_limit", "thermometer_limit", "chamber_alarm", "emergency_stop", "deadline", "program")
for cause, (reaction, other, shown) in POLICY.items():
    row = f'{{Cause::{cause}, "{cause}", Reaction::%s, {"false" if cause in ALWAYS else "true"}}}'
    MUTANTS.append((f"{cause} is answered by {other}", "rig/cause.cpp", row % reaction, row % other,
                    "faults_test", shown_by(shown)))
    if cause in ALWAYS and cause != "thermometer_limit":
        MUTANTS.append((f"{cause} may be chosen", "rig/cause.cpp",
                        row % reaction, (row % reaction).replace("false", "true"),
                        "rig_test", "Cause.WhatWouldDamageTheArticleCannotBeChosen"))


def commands(build, target):
    out = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True)
    return out.stdout.splitlines()


def run(program, test):
    return subprocess.run([program, "--gtest_filter=" + test], capture_output=True, text=True, timeout=120, check=False)


class Bench:
    """The compile and link commands of the build, bent to a mutant."""

    def __init__(self, build):
        self.build = pathlib.Path(build).resolve()
        self.links = {name: commands(build, name)[-1] for name in ("sequencer_test", "rig_test", "faults_test")}
        self.compiles = {}
        for line in commands(build, "rig_test"):
            source = re.search(r" -c (\S+)$", line)
            if source:
                path = (self.build / source.group(1)).resolve()
                if path.is_relative_to(ROOT):
                    self.compiles[str(path.relative_to(ROOT))] = line

    def mutate(self, folder, source, old, new):
        text = (ROOT / source).read_text()
        if text.count(old) != 1:
            return None
        mutant = folder / "mutant.cpp"
        mutant.write_text(text.replace(old, new))
        line = re.sub(r" -o \S+", " -o " + shlex.quote(str(folder / "mutant.o")), self.compiles[source])
        line = re.sub(r" -MF \S+", " -MF " + shlex.quote(str(folder / "mutant.d")), line)
        line = re.sub(r" -O[0-9]", " -O0", line)
        line = re.sub(r" -c \S+$", " -c " + shlex.quote(str(mutant)), line)
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)
        return folder / "mutant.o"

    def link(self, folder, program, mutant):
        line = self.links[program]
        line = re.search(r"\S*(?:g\+\+|c\+\+|clang\+\+)\S* .*", line).group(0)
        line = re.sub(r" -o (\S+)", " " + shlex.quote(str(mutant)) + " -o " + shlex.quote(str(folder / program)), line, count=1)
        line = re.split(r" && ", line)[0]
        subprocess.run(line, shell=True, cwd=self.build, check=True, capture_output=True)
        return folder / program


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    bench = Bench(sys.argv[1])
    chosen = [m for m in MUTANTS if len(sys.argv) < 3 or sys.argv[2] in m[0]]
    caught = 0
    for name, source, old, new, program, test in chosen:
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            before = run(str(bench.build / program), test)
            if before.returncode != 0 or "[  PASSED  ] 1 test" not in before.stdout:
                print(f"NO LAW    {name}: {test} does not pass as it is", flush=True)
                continue
            try:
                mutant = bench.mutate(folder, source, old, new)
                if mutant is None:
                    print(f"NO LINE   {name}: {source} does not say \"{old}\" once", flush=True)
                    continue
                ended = run(str(bench.link(folder, program, mutant)), test)
            except subprocess.CalledProcessError as error:
                print(f"NO BUILD  {name}: {error.stderr.decode()[-400:]}", flush=True)
                continue
            except subprocess.TimeoutExpired:
                ended = None  # a law that never ends is broken too
            fails = ended is None or ended.returncode != 0
            caught += fails
            print(f"{'caught   ' if fails else 'SURVIVES '} {name}: {test}", flush=True)
    print(f"{caught} of {len(chosen)} mutants caught")
    sys.exit(caught != len(chosen))


main()
