//! The screen of the view.
//!
//! In: a picture of the cell and the last answer. Out: widgets, from top to bottom: what the cell does, its speed, its
//! processes beside its robots, the last fault, the last answer, the keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Gauge, Paragraph, Row, Table, Wrap};

use super::keys::KEYS;
use mrroc_core::operator::button::CellState;
use mrroc_core::operator::state::Doing;
use mrroc_core::robot::MAX_JOINTS;
use mrroc_processes::{ENDED, Figures, Picture, Reply, RobotPicture};

/// What the screen shows.
#[derive(Debug, Default)]
pub(super) struct Screen {
    /// The newest picture.
    pub picture: Option<Picture>,
    /// The newest answer.
    pub reply: Option<Reply>,
    /// Why no more pictures and answers come, once the connection is closed.
    pub over: Option<String>,
}

/// The width of the processes when the robots are beside them \[columns\].
const PROCESSES: u16 = 76;
const ROBOTS: u16 = (LABEL + 9 * MAX_JOINTS + 2) as u16;
/// The width of a robot's name \[columns\].
const LABEL: usize = 15;

/// Draws the whole screen.
pub(super) fn draw(frame: &mut Frame<'_>, screen: &Screen) {
    let width = usize::from(frame.area().width).max(1);
    let no_reset = screen.picture.as_ref().is_some_and(|picture| picture.persisting.is_some());
    let rows = Layout::vertical([
        Constraint::Length(2),
        Constraint::Length(1),
        Constraint::Min(6),
        Constraint::Length(if no_reset { 4 } else { 3 }),
        Constraint::Length(if KEYS.chars().count() > width { 2 } else { 1 }),
    ]);
    let [top, speed, middle, bottom, keys] = rows.areas(frame.area());
    match &screen.picture {
        Some(picture) => {
            frame.render_widget(head(picture, screen.over.as_deref()), top);
            frame.render_widget(gauge(picture), speed);
            draw_processes_and_robots(frame, middle, picture);
        }
        None => frame.render_widget(Paragraph::new("waiting for the first picture ..").dim(), top),
    }
    frame.render_widget(messages(screen), bottom);
    frame.render_widget(Paragraph::new(KEYS).wrap(Wrap { trim: true }).dim(), keys);
}

fn colour(state: CellState) -> Color {
    match state {
        CellState::Idle => Color::Gray,
        CellState::Running => Color::Green,
        CellState::Suspended | CellState::Aborting | CellState::Resetting => Color::Yellow,
        CellState::Stopping | CellState::Latched | CellState::Acknowledged => Color::Red,
    }
}

/// The state, the step, the instruction, and how late steps begin.
fn head(picture: &Picture, over: Option<&str>) -> Paragraph<'static> {
    let millis = |nanos: u64| nanos as f64 * 1e-6;
    let (state, colour) = match over {
        Some(ENDED) => ("ended", Color::Gray),
        // What the picture shows is not what the cell does now.
        Some(_) => ("no connection", Color::Red),
        None => (picture.state.word(), colour(picture.state)),
    };
    let over = over == Some(ENDED);
    let badge = Style::new().fg(Color::Black).bg(colour).add_modifier(Modifier::BOLD);
    let instruction = match picture.doing {
        Doing::Nothing if over => format!("instruction {}: over", picture.instructions),
        Doing::Nothing => format!("instruction {}: over, the program computes", picture.instructions),
        doing => format!("instruction {}: {} {}", picture.instructions, doing.word(), picture.by_whom()),
    };
    let holder = match picture.holder {
        Some(holder) => format!("control: the console of process {holder}"),
        None => "control: nobody".to_owned(),
    };
    Paragraph::new(vec![
        Line::from(vec![
            Span::styled(format!(" {state} "), badge),
            Span::raw(format!("  step {} of {} ms   {holder}", picture.step, millis(picture.period))),
        ]),
        Line::from(instruction + &cells(picture)),
    ])
}

/// The states of its lower cells, behind other words; nothing where it has none.
fn cells(picture: &Picture) -> String {
    let states: Vec<_> =
        picture.cells.iter().map(|cell| format!("{} {}", cell.name, cell.state.word())).collect();
    if states.is_empty() { String::new() } else { format!("   cells: {}", states.join(", ")) }
}

/// The rate of path time, and the speed that is set.
fn gauge(picture: &Picture) -> Gauge<'static> {
    let label = format!(
        "rate {:.0} % of speed {:.0} %{}",
        100.0 * picture.rate,
        100.0 * picture.speed,
        picture.reduction()
    );
    let rate = if picture.rate.is_finite() { picture.rate.clamp(0.0, 1.0) } else { 0.0 };
    Gauge::default().ratio(rate).label(label).gauge_style(Style::new().fg(colour(picture.state)))
}

fn draw_processes_and_robots(frame: &mut Frame<'_>, area: Rect, picture: &Picture) {
    // Side by side, or one below the other where a line is too short for both.
    // A line more where programs of ECPs have moved: it stays when a motion is over, so that nothing jumps.
    let each = if picture.robots.iter().any(|robot| !robot.by.is_empty()) { 3 } else { 2 };
    let lines = each * picture.robots.len() as u16 + 2;
    let (left, right) = if area.width >= PROCESSES + ROBOTS {
        let columns = Layout::horizontal([Constraint::Length(PROCESSES), Constraint::Min(ROBOTS)]);
        let [left, right] = columns.areas(area);
        (left, right)
    } else {
        let robots = lines.min(area.height / 2);
        let [left, right] = Layout::vertical([Constraint::Min(3), Constraint::Length(robots)]).areas(area);
        (left, right)
    };
    // What has no room is counted and mentioned.
    let fits = |area: Rect, frame: u16, each: u16| usize::from(area.height.saturating_sub(frame) / each);
    let title = |what: &str, all: usize, fits: usize| {
        if all > fits { format!("{what}: {fits} of {all}, more in a larger window") } else { what.to_owned() }
    };
    let processes = picture.processes.iter().map(|process| {
        let state = if process.runs { "runs".green() } else { "ended".red() };
        let Figures { late, worked, skipped, overruns, .. } = process.figures;
        let micros = |nanos: u64| format!("{:>7.0}", nanos as f64 * 1e-3);
        let numbers = [worked.count, skipped, overruns].map(|count| format!("{count:>7}"));
        let words = [process.name.clone(), process.pid.to_string()].into_iter().chain(numbers);
        let words = words.chain([micros(late.p99), micros(late.max)]).map(Line::from);
        Row::new(words.chain([Line::from(state)]))
    });
    let number = Constraint::Length(7);
    let widths = [Constraint::Fill(1), number, number, number, number, number, number, Constraint::Length(5)];
    let names = ["process", "number", "  steps", "skipped", "overrun", "p99 us", " max us", ""];
    let header = Row::new(names).dim();
    frame.render_widget(
        Table::new(processes, widths).header(header).block(Block::bordered().title(title(
            "processes",
            picture.processes.len(),
            fits(left, 3, 1),
        ))),
        left,
    );
    let whole = fits(right, 2, each);
    let lines: Vec<_> =
        picture.robots.iter().take(whole).flat_map(|of| robot(of).into_iter().take(each.into())).collect();
    let what = "robots: demanded, and error [rad or m]";
    let block = Block::bordered().title(title(what, picture.robots.len(), whole));
    frame.render_widget(Paragraph::new(lines).block(block), right);
}

/// The demanded joint positions of a robot, how far its joints are from them, and what its own program does.
fn robot(robot: &RobotPicture) -> [Line<'static>; 3] {
    let row =
        |numbers: &mut dyn Iterator<Item = f64>| numbers.map(|q| format!(" {q:8.4}")).collect::<String>();
    let errors = robot.demanded.iter().zip(&robot.measured).map(|(demanded, measured)| measured - demanded);
    let short: String = robot.name.chars().take(LABEL).collect();
    let (name, time) = (format!("{short:LABEL$}"), format!("{:LABEL$}", format!(" {:.3} s", robot.time)));
    [
        Line::from(vec![name.bold(), Span::raw(row(&mut robot.demanded.iter().copied()))]),
        Line::from(vec![time.dim(), Span::raw(row(&mut { errors }))]),
        Line::from(format!("{:LABEL$} {}", "", robot.motion().trim_start_matches(": "))),
    ]
}

/// The last fault, and the answer to the last key.
fn messages(screen: &Screen) -> Paragraph<'static> {
    let fault = screen.picture.as_ref().and_then(|picture| picture.fault.clone());
    let persisting = screen.picture.as_ref().and_then(|picture| picture.persisting.as_ref());
    let no_reset =
        persisting.map(|why| Line::from(format!("a reset failed or would be refused: {why}")).red());
    let fault = match fault {
        Some(fault) => Line::from(format!("last fault: {fault}")).red(),
        None => Line::from("last fault: none").dim(),
    };
    let reply = match &screen.reply {
        _ if screen.over.is_some() => {
            let why = screen.over.clone().unwrap_or_default();
            Line::from(format!("{why}: this is the last that was seen of it; q quits")).bold()
        }
        Some(Reply::Done(text)) => Line::from(text.clone()).green(),
        Some(Reply::Refused(text)) => Line::from(format!("refused: {text}")).yellow(),
        Some(Reply::Pending(text)) => Line::from(format!("pending: {text}")).yellow(),
        None => Line::default(),
    };
    let lines: Vec<_> = [Some(fault), no_reset, Some(reply)].into_iter().flatten().collect();
    Paragraph::new(lines).wrap(Wrap { trim: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::operator::jog::JogStop;
    use mrroc_core::pose::Pose;
    use mrroc_processes::{CellPicture, ProcessPicture, Spread};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn picture() -> Picture {
        let late = Spread { count: 1200, p50: 30_000, p99: 61_000, max: 480_000 };
        let figures = Figures { late, worked: late, skipped: 3, overruns: 2, dropped: 0 };
        Picture {
            state: CellState::Suspended,
            step: 1203,
            period: 2_000_000,
            epoch: 0,
            rate: 0.25,
            speed: 0.5,
            reduced: false,
            held: false,
            instructions: 4,
            doing: Doing::Move,
            by: "Swing".to_owned(),
            holder: Some(4711),
            fault: Some("mp: aborted by the operator at step 77".to_owned()),
            help: None,
            persisting: None,
            cells: Vec::new(),
            processes: vec![
                ProcessPicture { name: "mp".to_owned(), pid: 100, runs: true, figures },
                ProcessPicture {
                    name: "vsp count".to_owned(),
                    pid: 101,
                    runs: false,
                    figures: Figures::default(),
                },
            ],
            robots: vec![RobotPicture {
                name: "left".to_owned(),
                time: 2.406,
                demanded: vec![0.5, -1.57],
                measured: vec![0.501, -1.572],
                tool: Pose::identity(),
                doing: Doing::Nothing,
                by: String::new(),
                jogs: false,
                stop: JogStop::None,
            }],
            ..Picture::default()
        }
    }

    /// The screen as lines of text.
    fn drawn(screen: &Screen, (width, height): (u16, u16)) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal of memory");
        terminal.draw(|frame| draw(frame, screen)).expect("drawn");
        let buffer = terminal.backend().buffer();
        let row = |y| (0..width).map(|x| buffer[(x, y)].symbol()).collect::<String>();
        (0..height).map(row).collect()
    }

    #[test]
    fn what_forbids_a_reset_is_below_the_last_fault_and_hides_no_answer() {
        let reply = Some(Reply::Refused("the cause of the fault persists: step 9".to_owned()));
        let persisting = Some("edp arm: drive fault: the brake".to_owned());
        let latched = Picture { state: CellState::Latched, persisting, ..picture() };
        let lines =
            drawn(&Screen { picture: Some(latched), reply, ..Screen::default() }, (100, 24)).join("\n");
        for told in [
            "last fault: mp",
            "a reset failed or would be refused: edp arm: drive fault: the brake",
            "refused: the cause",
        ] {
            assert!(lines.contains(told), "{told}: {lines}");
        }
    }

    #[test]
    fn everything_of_a_picture_is_on_the_screen() {
        let reply = Some(Reply::Refused("it is suspended: step 1203".to_owned()));
        let lines = drawn(&Screen { picture: Some(picture()), reply, over: None }, (200, 24));
        for told in [
            "suspended   step 1203 of 2 ms   control: the console of process 4711",
            "instruction 4: move Swing",
            "rate 25 % of speed 50 %",
            "2.406 s",
            "last fault: mp: aborted by the operator at step 77",
            "refused: it is suspended: step 1203",
            "space stop",
        ] {
            assert!(lines.iter().any(|line| line.contains(told)), "{told} in {lines:#?}");
        }
        // The lines of a process and its state, and of a robot's demanded joints and their distances.
        let line = |begins: &str| lines.iter().find(|line| line.contains(begins)).expect(begins);
        let mp: Vec<_> = line("mp ").split_whitespace().take(9).collect();
        assert_eq!(mp[..8], ["│mp", "100", "1200", "3", "2", "61", "480", "runs"], "{lines:#?}");
        assert!(line("vsp count").contains("101") && line("vsp count").contains("ended"));
        assert!(line("left ").contains("0.5000  -1.5700"));
        assert!(line("2.406 s").contains("0.0010  -0.0020"));
    }

    #[test]
    fn lower_cells_are_shown_with_their_states() {
        let mut own = picture();
        let state = CellState::Latched;
        own.cells = vec![CellPicture { name: "press".to_owned(), state, ..CellPicture::default() }];
        let lines = drawn(&Screen { picture: Some(own), reply: None, over: None }, (200, 24));
        assert!(lines.iter().any(|line| line.contains("cells: press latched")), "{lines:#?}");
    }

    #[test]
    fn what_the_programs_of_ecps_do_is_shown_with_their_robots() {
        let mut own = picture();
        // An MP without a program has no generator.
        own.by = String::new();
        own.robots[0].doing = Doing::Wait;
        own.robots[0].by = "ForceAbove".to_owned();
        let mut other = own.robots[0].clone();
        (other.name, other.doing, other.by) = ("right".to_owned(), Doing::Nothing, "Line".to_owned());
        own.robots.push(other);
        let lines = drawn(&Screen { picture: Some(own), ..Screen::default() }, (200, 24));
        assert!(lines[1].contains("instruction 4: move of each robot by its own program"), "{lines:#?}");
        let left = lines.iter().position(|line| line.contains("left ")).expect("the left robot");
        assert!(lines[left + 2].contains(" wait ForceAbove"), "{lines:#?}");
        // The motion of the right one is over.
        assert!(
            lines[left + 3].contains("right ") && !lines.iter().any(|line| line.contains("Line")),
            "{lines:#?}"
        );
    }

    #[test]
    fn a_small_terminal_shows_names_numbers_and_keys_whole_and_tells_what_finds_no_room() {
        let mut crowded = picture();
        crowded.robots[0].demanded = vec![-1.5; MAX_JOINTS - 1];
        crowded.robots[0].measured = vec![-1.5; MAX_JOINTS - 1];
        crowded.processes = vec![crowded.processes[0].clone(); 12];
        crowded.processes[0].name = "ecp polycrank-hand".to_owned();
        let lines = drawn(&Screen { picture: Some(crowded), ..Screen::default() }, (80, 24));
        let line = |told: &str| {
            lines.iter().find(|line| line.contains(told)).unwrap_or_else(|| panic!("{lines:#?}"))
        };
        assert!(line("ecp polycrank-hand ").contains(" runs"));
        assert_eq!(line("left ").matches("-1.5000").count(), MAX_JOINTS - 1);
        assert!(line("of 12").contains("a larger window"));
        assert!(
            line("q quit").contains("acknowledge") || lines.iter().any(|line| line.contains("acknowledge"))
        );
    }

    #[test]
    fn a_cell_that_does_not_answer_is_not_shown_as_one_that_has_ended() {
        let over = Some("the cell has not answered for 5 s".to_owned());
        let lines = drawn(&Screen { picture: Some(picture()), reply: None, over }, (80, 24));
        assert!(lines[0].starts_with(" no connection "), "{lines:#?}");
        assert!(!lines.iter().any(|line| line.contains("has ended")), "{lines:#?}");
    }

    #[test]
    fn a_cell_that_has_ended_is_shown_as_one_whatever_it_did_last() {
        let over = Some("the cell has ended".to_owned());
        let reply = Some(Reply::Done("resumed: step 3".to_owned()));
        let lines = drawn(&Screen { picture: Some(picture()), reply, over }, (80, 24));
        assert!(lines[0].starts_with(" ended "), "{lines:#?}");
        assert!(lines.iter().any(|line| line.starts_with("the cell has ended: ")), "{lines:#?}");
        assert!(!lines.iter().any(|line| line.contains("resumed")), "{lines:#?}");
    }

    #[test]
    fn the_screen_says_so_when_there_is_nothing_to_see_yet() {
        let lines = drawn(&Screen::default(), (80, 20));
        assert!(lines[0].contains("waiting for the first picture"), "{lines:#?}");
    }

    #[test]
    fn no_size_of_a_terminal_is_too_small_to_draw_on() {
        let mut crowded = picture();
        crowded.rate = f64::NAN;
        crowded.robots = vec![crowded.robots[0].clone(); 64];
        crowded.processes = vec![crowded.processes[0].clone(); 64];
        let screen = Screen { picture: Some(crowded), ..Screen::default() };
        for size in [(1, 1), (3, 2), (20, 5), (40, 10), (300, 100)] {
            drawn(&screen, size);
        }
    }
}
