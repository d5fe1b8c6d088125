//! The command line: what is read, what is refused, and the help.

use super::*;
use clap::CommandFactory;

fn run(line: &str) -> Result<Options, clap::Error> {
    parse(line.split_whitespace().map(OsString::from))
}

fn options(line: &str) -> Options {
    run(line).unwrap()
}

#[test]
fn a_text_longer_than_any_plate_is_refused() {
    let long = "a".repeat(MOST_CHARACTERS + 1);
    let error = parse(["--text".into(), long.into()]).expect_err("too long");
    assert!(error.to_string().contains("2001 characters"), "{error}");
}

#[test]
fn no_argument_engraves_the_nameplate() {
    let expected = Options {
        source: Source::Nameplate,
        out: PathBuf::from("engraving"),
        sizing: Sizing::Natural,
        plate: Plate::default(),
        cutter: Cutter::default(),
        depth: None,
        feed: None,
        reading: Reading::default(),
        step: 0.002,
        processes: None,
        talk: Talk::Normal,
    };
    assert_eq!(options(""), expected);
}

#[test]
fn all_options_are_read() {
    let found = options(
        "a.svg --plate 300x200 --margin 5 --size=100x50 --tool ball:2 --depth 0.5 --feed 30 --step-ms 1 -o x -q",
    );
    assert_eq!(found.source, Source::File("a.svg".into()));
    assert_eq!(found.plate, Plate { width: 300.0, height: 200.0, margin: 5.0 });
    assert_eq!(found.sizing, Sizing::Within { width: 100.0, height: 50.0 });
    assert_eq!(found.cutter, Cutter::Ball { radius: 1.0 });
    assert_eq!((found.depth, found.feed, found.step), (Some(0.5), Some(30.0), 0.001));
    assert_eq!((found.out, found.talk), ("x".into(), Talk::Quiet));
    assert_eq!(found.processes, None);
    assert_eq!(options("--processes").processes, Some(Clock::Real));
    for both in ["--virtual", "--processes --virtual", "--virtual --processes"] {
        assert_eq!(options(both).processes, Some(Clock::Virtual));
    }
    assert_eq!(options("--text Hi").sizing, Sizing::Fill);
    assert_eq!(options("a.svg --fit").sizing, Sizing::Fill);
    assert_eq!(options("--text Hi --scale 2").sizing, Sizing::Scale(2.0));
    let text = Source::Text { text: "-5\n6".to_owned(), font: DEFAULT_FONT.to_owned() };
    assert_eq!(options(r"--text -5\n6").source, text);
    assert_eq!(options("--depth 1 --depth 2").depth, Some(2.0));
    let gcode = options("a.ngc --surface -30 --block-delete off").reading.gcode;
    assert_eq!((gcode.surface, gcode.block_delete), (-30.0, BlockDelete::Off));
    let pen = |line: &str| options(line).reading.gcode.pen;
    assert_eq!(pen("a.gcode"), PenLift::Auto);
    assert_eq!(pen("a.gcode --pen z"), PenLift::Height);
    assert_eq!(pen("a.gcode --pen M280:30"), PenLift::Word { signal: Signal::Servo, down: Some(30.0) });
    assert_eq!(pen("a.gcode --pen m3:s0"), PenLift::Word { signal: Signal::Spindle, down: Some(0.0) });
    assert_eq!(run("--help").expect_err("help").kind(), ErrorKind::DisplayHelp);
    assert_eq!(run("-V").expect_err("version").kind(), ErrorKind::DisplayVersion);
}

#[test]
fn wrong_options_say_what_to_write() {
    for (line, part) in [
        ("--plat 3x4", "a similar argument exists: '--plate'"),
        ("--zzzzzz", "For more information, try '--help'"),
        ("--depth -1", "0.001 to 20"),
        ("--depth nan", "0.001 to 20"),
        ("--plate 3", "'--plate <WxH>': give width and height in mm up to 2000, as 200x120"),
        ("--plate 3xx4", "as 200x120"),
        ("--plate 3x4xy", "as 200x120"),
        ("--step-ms 3", "a multiple of 2"),
        ("--step-ms 1.5", "a multiple of 2"),
        ("--size 3x4 --fit", "'--size <WxH>' cannot be used with '--fit'"),
        ("a.svg b.svg", "two files"),
        ("a.svg --text x", "both say what to engrave"),
        ("--font x", "--font without --text"),
        ("--feed", "a value is required for '--feed <MM/S>'"),
        ("--margin 90", "leaves nothing"),
        ("--tool spoon", "v:90"),
        ("--pen up", "auto, z, m3, m280 or m300"),
        ("--pen z:3", "as m280:30"),
        ("--pen m300:nan", "as m280:30"),
    ] {
        let message = run(line).unwrap_err().to_string();
        assert!(message.contains(part), "{line}: {message}");
    }
}

#[test]
fn the_help_fits_a_terminal_and_names_every_font() {
    Arguments::command().debug_assert();
    let help = run("--help").unwrap_err().to_string();
    assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    let words: Vec<_> = help.split_whitespace().collect();
    assert!(words.join(" ").contains(&fonts()), "{help}");
}
