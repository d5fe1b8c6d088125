//! Sweeps of small cells: every process is killed and stalled, and every link has faults, in every step.

use mrroc::cell::Cell;
use mrroc::testing::{LinkFault, Press, Sweep, SweepReport};

use crate::runtime::lower_cells::plant;
use crate::safety::cells::{cooperating, interpolated, sensing, transparent};

/// Injects faults into a cell's processes and links, and by its operator.
pub fn everything(cell: fn() -> Cell) -> Sweep<'static> {
    let sweep = Sweep::new(cell).threads(2);
    let sweep = [1, 5, 19, 20, 21, 100].into_iter().fold(sweep.kills(), Sweep::stalls);
    let sweep = [1, 19, 20, 21].into_iter().fold(sweep, |sweep, n| sweep.links(LinkFault::Drop, n));
    let faults = [
        LinkFault::Duplicate,
        LinkFault::Reorder,
        LinkFault::Delay(1),
        LinkFault::Delay(3),
        LinkFault::Corrupt,
        LinkFault::Replay,
        LinkFault::Forge,
    ];
    let sweep = faults.into_iter().fold(sweep, |sweep, fault| sweep.links(fault, 3));
    let presses = [
        Press::Abort,
        Press::Stop,
        Press::SuspendAndResume(50),
        Press::SuspendAndResume(5),
        Press::Everything,
    ];
    presses.into_iter().fold(sweep, Sweep::presses)
}

fn clean(report: &SweepReport) {
    println!("{report}");
    assert!(report.is_clean(), "{report}");
}

/// Asserts that there are more than so many cases, that no promise was broken, and that all runs went on to their end.
fn all_go_on(sweep: Sweep<'_>, more_than: u64) {
    let report = sweep.threads(2).run();
    let total = report.total();
    assert!(report.is_clean() && total.cases > more_than && total.survived == total.cases, "{report}");
}

/// Asserts the same, but that all runs stopped.
fn all_stop(sweep: Sweep<'_>, more_than: u64) {
    let report = sweep.threads(2).run();
    let total = report.total();
    assert!(report.is_clean() && total.cases > more_than && total.stopped == total.cases, "{report}");
}

/// How many times as many steps a test leaves out as `just test-whole` does.
const SHARE: u64 = 3;

fn faults_in_small_cells(every: u64) {
    for cell in [transparent, cooperating, interpolated, sensing] {
        clean(&everything(cell).every(29 * every).run());
    }
}

#[test]
fn every_fault_in_a_share_of_the_steps_of_small_cells_breaks_no_promise() {
    faults_in_small_cells(SHARE);
}

/// Two cells under one MP. When that MP is killed, they have the bound of fault 162, which has a test of its own.
fn faults_of_links_in_a_plant(every: u64) {
    let sweep = [1, 5, 20, 21, 100].into_iter().fold(Sweep::new(plant).threads(2), Sweep::stalls);
    let sweep = [1, 19, 20, 21, 60].into_iter().fold(sweep, |sweep, n| sweep.links(LinkFault::Drop, n));
    let faults = [
        LinkFault::Duplicate,
        LinkFault::Reorder,
        LinkFault::Delay(3),
        LinkFault::Corrupt,
        LinkFault::Replay,
        LinkFault::Forge,
    ];
    let sweep = faults.into_iter().fold(sweep, |sweep, fault| sweep.links(fault, 3));
    let presses = [Press::Abort, Press::Stop, Press::SuspendAndResume(50), Press::Everything];
    clean(&presses.into_iter().fold(sweep, Sweep::presses).every(97 * every).run());
}

#[test]
fn fault_169_faults_of_links_in_a_plant_break_no_promise() {
    // Its runs are the longest.
    faults_of_links_in_a_plant(3 * SHARE);
}

#[test]
#[ignore = "takes minutes: `just sweep`"]
fn every_fault_in_every_step_of_small_cells_breaks_no_promise() {
    let mut all = SweepReport::default();
    for cell in [transparent, cooperating, interpolated, sensing] {
        all.absorb(everything(cell).run());
    }
    clean(&all);
}

#[test]
fn fault_14_what_links_lose_for_up_to_twenty_steps_is_sent_again_and_every_motion_ends_where_it_should() {
    for steps in [1, 2, 19, 20] {
        for cell in [transparent, cooperating, interpolated] {
            all_go_on(Sweep::new(cell).links(LinkFault::Drop, steps).every(23), 20);
        }
    }
    // A robot that follows a sensor gets a jump as demand once the readings of 19 steps are missing.
    all_go_on(Sweep::new(sensing).links(LinkFault::Drop, 1).every(7), 100);
    clean(&Sweep::new(sensing).links(LinkFault::Drop, 19).every(23).threads(2).run());
}

#[test]
fn fault_14_links_that_lose_everything_for_longer_end_in_an_orderly_stop() {
    for cell in [transparent, cooperating, interpolated, sensing] {
        all_stop(Sweep::new(cell).links(LinkFault::Drop, 21).every(23), 20);
    }
}

#[test]
fn fault_39_a_link_that_was_cut_and_comes_back_moves_nothing() {
    // The process comes back while the robots stop, and when they stand: no robot that stood begins to move.
    for steps in [30, 60, 150] {
        for cell in [transparent, cooperating, interpolated, sensing] {
            all_stop(Sweep::new(cell).links(LinkFault::Drop, steps).every(37), 10);
        }
    }
}

fn messages_come_twice_late_or_again(every: u64) {
    for cell in [transparent, cooperating, interpolated, sensing] {
        // Doubled and old messages are ignored: every run ends as the undisturbed one does, to 1e-12 m.
        let sweep = Sweep::new(cell).links(LinkFault::Duplicate, 3).links(LinkFault::Replay, 3);
        all_go_on(sweep.every(11 * every).end_tolerance(1e-12), 100 / every);
        clean(&Sweep::new(cell).links(LinkFault::Reorder, 3).every(11 * every).threads(2).run());
    }
}

#[test]
fn fault_15_messages_that_come_twice_late_or_again_change_nothing() {
    messages_come_twice_late_or_again(SHARE);
}

/// Path time that passes again comes with demands of its own for robots that held meanwhile.
fn demands_are_late_after_a_suspension(every: u64) {
    for (cell, suspended) in [(transparent as fn() -> Cell, 60), (cooperating, 150), (interpolated, 60)] {
        let suspended_for_a_while = move || {
            let mut pressed = 0;
            cell().also_on_step(move |step, operator| {
                // An MP that is late leaves steps out.
                if pressed == 0 && step >= suspended {
                    pressed = 1;
                    operator.suspend();
                } else if pressed == 1 && step >= suspended + 60 {
                    pressed = 2;
                    operator.resume();
                }
            })
        };
        let late = (1..=6).fold(Sweep::new(suspended_for_a_while), |sweep, steps| {
            sweep.links(LinkFault::Delay(steps), 8).links(LinkFault::Drop, steps).stalls(steps)
        });
        all_go_on(late.every(7 * every), 200 / every);
    }
}

#[test]
fn fault_22_motions_whose_demands_are_late_after_a_suspension_go_on_late_and_end_where_they_should() {
    demands_are_late_after_a_suspension(5 * SHARE);
}

#[test]
fn fault_16_a_damaged_message_is_a_lost_one() {
    for cell in [transparent, cooperating, interpolated, sensing] {
        let lost = Sweep::new(cell).links(LinkFault::Drop, 1).every(31).threads(2).run();
        let damaged = Sweep::new(cell).links(LinkFault::Corrupt, 1).every(31).threads(2).run();
        assert!(damaged.is_clean(), "{damaged}");
        let (lost, damaged) = (lost.total(), damaged.total());
        assert_eq!((lost.cases, lost.stopped), (damaged.cases, damaged.stopped), "{lost:?} {damaged:?}");
    }
}

fn senders_are_out_of_their_minds(every: u64) {
    for cell in [transparent, cooperating, interpolated, sensing] {
        clean(&Sweep::new(cell).links(LinkFault::Forge, 1).every(3 * every).threads(2).run());
    }
}

#[test]
fn a_sender_that_is_out_of_its_mind_gets_nothing_beyond_a_limit_to_the_drives() {
    senders_are_out_of_their_minds(SHARE);
}

#[test]
fn what_is_wrong_with_a_cell_or_its_undisturbed_run_is_a_failure_and_no_case() {
    let wrong = || Cell::new(mrroc_tests::MS);
    let report = Sweep::new(wrong).kills().run();
    assert!(!report.is_clean() && report.total().cases == 0, "{report}");
    let fails = || transparent().program(|_| Err(mrroc::fault::Fault::thrown("the box is empty")));
    let report = Sweep::new(fails).kills().run();
    assert!(report.to_string().contains("the box is empty"), "{report}");
}

fn copies_come_to_the_same(every: u64) {
    for cell in [transparent, cooperating, interpolated, sensing] {
        let sorted = |report: SweepReport| {
            let mut rows = report.rows().to_vec();
            rows.sort_by(|(a, _), (b, _)| a.cmp(b));
            (rows, report)
        };
        let every = 61 * every;
        let (alone, report) = sorted(everything(cell).every(every).run());
        let (copied, copies) = sorted(everything(cell).every(every).forking(u64::MAX).run());
        assert_eq!(alone, copied, "{report}\n{copies}");
        assert!(report.is_clean() && copies.is_clean(), "{report}\n{copies}");
    }
}

#[test]
fn copies_of_one_run_come_to_what_runs_of_their_own_come_to() {
    copies_come_to_the_same(SHARE);
}

#[test]
fn a_case_that_is_repeated_comes_to_the_same() {
    use mrroc::testing::{Case, Injected};
    let sweep = Sweep::new(cooperating);
    let case = Case { injected: Injected::Kill(mrroc::fault::ProcessId::MP), at: 100, seed: 5 };
    let (first, second) = (sweep.repeat(&case), sweep.repeat(&case));
    assert!(first.total().stopped == 1 && first == second, "{first}");
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn every_fault_in_a_share_of_the_steps_of_small_cells_breaks_no_promise() {
        super::faults_in_small_cells(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn fault_169_faults_of_links_in_a_plant_break_no_promise() {
        super::faults_of_links_in_a_plant(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn fault_15_messages_that_come_twice_late_or_again_change_nothing() {
        super::messages_come_twice_late_or_again(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn fault_22_motions_whose_demands_are_late_after_a_suspension_go_on_late_and_end_where_they_should() {
        super::demands_are_late_after_a_suspension(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn a_sender_that_is_out_of_its_mind_gets_nothing_beyond_a_limit_to_the_drives() {
        super::senders_are_out_of_their_minds(1);
    }

    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn copies_of_one_run_come_to_what_runs_of_their_own_come_to() {
        super::copies_come_to_the_same(1);
    }
}
