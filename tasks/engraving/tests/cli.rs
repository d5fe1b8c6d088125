//! The program as its user meets it: runs, pictures, figures, exit status, and what it says to bad input.

use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("the target folder can be written");
    folder
}

fn engraving(folder: &PathBuf, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_engraving"));
    command.current_dir(folder).args(arguments).output().expect("the program starts")
}

fn figures(folder: &std::path::Path) -> serde_json::Value {
    let text =
        std::fs::read_to_string(folder.join("engraving/summary.json")).expect("the summary was written");
    serde_json::from_str(&text).expect("the summary is JSON")
}

fn number(value: &serde_json::Value, pointer: &str) -> f64 {
    value
        .pointer(pointer)
        .and_then(serde_json::Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {pointer}"))
}

#[test]
fn a_text_is_engraved_within_the_bounds_and_shown() {
    let folder = folder("text");
    let output = engraving(&folder, &["--text", "ab", "--size", "30x20", "--quiet"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "--quiet said something");
    let figures = figures(&folder);
    assert_eq!(figures["passed"], true);
    assert!(number(&figures, "/demanded/max_mm/value") <= 0.01);
    assert!(number(&figures, "/executed/max_mm/value") <= 0.3);
    assert!(number(&figures, "/executed/rms_mm/value") <= 0.1);
    // A real arm is no echo: its error is neither zero nor the demand's.
    assert!(number(&figures, "/executed/rms_mm/value") > 10.0 * number(&figures, "/demanded/rms_mm/value"));
    // The probe found a plate that lies 1.7 mm lower than promised.
    assert!((number(&figures, "/plate_height/found_mm") + 1.7).abs() < 0.02);
    assert!((number(&figures, "/simulated_s") - number(&figures, "/steps") * 0.002).abs() < 0.01);
    let png = std::fs::read(folder.join("engraving/plate.png")).expect("the picture was written");
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let svg = std::fs::read_to_string(folder.join("engraving/paths.svg")).expect("the paths were written");
    assert!(roxmltree::Document::parse(&svg).is_ok());
}

#[test]
fn the_same_job_gives_the_same_figures_to_the_bit() {
    let run = |name: &str| {
        let folder = folder(name);
        let output = engraving(&folder, &["--text", "o", "--size", "10x10", "--quiet"]);
        assert!(output.status.success());
        let mut figures = figures(&folder);
        // Time on the wall is the only thing that may differ.
        figures["wall_s"] = 0.into();
        (figures, std::fs::read(folder.join("engraving/plate.png")).expect("the picture was written"))
    };
    assert_eq!(run("once"), run("twice"));
}

/// The sample drawings, but for some.
fn samples_are_engraved(but: &[&str]) {
    let samples = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/drawings");
    let files = std::fs::read_dir(samples).expect("the samples are there");
    let mut files: Vec<_> = files.map(|entry| entry.expect("the samples can be listed").path()).collect();
    files.retain(|path| {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        ["svg", "dxf", "gcode", "ngc"].contains(&ending.as_str())
    });
    assert!(files.len() >= 10, "{files:?}");
    files.retain(|path| but.iter().all(|but| !path.ends_with(but)));
    // The largest of them take most of the time: two at once.
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for half in ["samples-a", "samples-b"] {
            let (files, next) = (&files, &next);
            scope.spawn(move || {
                let folder = folder(half);
                while let Some(path) = files.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    let output = engraving(&folder, &[&path.to_string_lossy(), "--fit", "--quiet"]);
                    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
                    assert!(output.status.success(), "{}: {errors}", path.display());
                }
            });
        }
    });
}

#[test]
fn sample_drawings_are_engraved_within_the_bounds() {
    // These take as long as all others together, and the nameplate is engraved by other tests.
    samples_are_engraved(&["nameplate.svg", "gcodecrate_circle_a.gcode"]);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just test-whole`"]
    fn every_sample_drawing_is_engraved_within_the_bounds() {
        super::samples_are_engraved(&[]);
    }
}

#[test]
fn a_program_is_engraved_as_deep_and_as_fast_as_it_says() {
    let folder = folder("depth");
    let program = "G21 G0 X0 Y0 Z4\nG1 Z-2 F120\nG1 X20 F600\nG2 X20 Y0 I-5 Z-1 P2\nG0 Z4\n";
    std::fs::write(folder.join("a.ngc"), program).expect("the folder can be written");
    let output = engraving(&folder, &["a.ngc"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    for row in ["2 mm, from the file", "2 to 10 mm/s, from the file", "4 mm, from the file"] {
        assert!(said.contains(row), "{said}");
    }
    let from_file = figures(&folder);
    assert_eq!(from_file["depth_mm"]["by"], "file");
    // Down 2, along 20, two turns that rise by 1, up 1 and out. The true tip's path is a little longer: the arm shakes,
    // and its probe goes into the plate where it touches it.
    let length = 2.0 + 20.0 + (2.0 * 10.0 * std::f64::consts::PI).hypot(1.0) + 1.0;
    let cut = number(&from_file, "/cut_length_mm");
    assert!((length..1.01 * length).contains(&cut), "{from_file}");
    let output = engraving(&folder, &["a.ngc", "--depth", "0.5", "--feed", "30"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("0.5 mm, by --depth") && said.contains("30 mm/s, by --feed"), "{said}");
}

#[test]
fn a_step_that_is_too_long_to_stop_at_the_plate_misses_a_bound_and_says_so() {
    let folder = folder("slow");
    let output = engraving(&folder, &["--text", "w", "--size", "10x10", "--step-ms", "100", "--quiet"]);
    let (figures, errors) = (figures(&folder), String::from_utf8_lossy(&output.stderr).into_owned());
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(figures["passed"], false);
    // At 1 mm/s the probe is read every 0.1 mm: the height cannot be found to 0.02 mm but by chance.
    assert!((number(&figures, "/plate_height/found_mm") + 1.7).abs() > 0.02);
    assert!(errors.contains("bound missed: plate found at"), "{errors}");
}

#[cfg(target_os = "linux")]
#[test]
fn outputs_that_cannot_be_written_are_reported_and_a_closed_pipe_is_not() {
    let folder = folder("full");
    let to = |stdout: std::process::Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_engraving"));
        let child =
            command.current_dir(&folder).arg("--help").stdout(stdout).stderr(std::process::Stdio::piped());
        child.spawn().and_then(std::process::Child::wait_with_output).expect("the program starts")
    };
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let output = to(full.into());
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output cannot be written"));
    let (reader, writer) = std::io::pipe().expect("a pipe can be made");
    drop(reader);
    assert!(to(writer.into()).status.success());
    std::fs::create_dir_all(folder.join("engraving/plate.png")).expect("the folder can be written");
    let output = engraving(&folder, &["--text", "o", "--size", "5x5", "--quiet"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("engraving/plate.png: cannot be written"));
}

#[test]
fn bad_input_is_refused_with_status_2_before_anything_is_written() {
    let cases: [(&str, &[u8], &[&str], &str); 9] = [
        ("empty.svg", b"<svg xmlns='http://www.w3.org/2000/svg'/>", &[], "empty.svg"),
        ("cut.svg", b"<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0L", &[], "cut.svg:1"),
        ("arc.ngc", b"G21 G90\nG0 X0 Y0\nG1 Z-1 F100\nG2 X10 Y0 I1 J0\n", &[], "arc.ngc:4"),
        ("feed.ngc", b"G21 G90\nG0 X0 Y0\nG1 Z-1 F0\nG1 X10\n", &[], "feed.ngc:3"),
        ("word.ngc", b"G21\nG1 Q\xc3\xa4\n", &[], "word.ngc:2"),
        ("nan.svg", b"<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0L1e999 0'/></svg>", &[], "nan.svg"),
        ("large.svg", b"<svg xmlns='http://www.w3.org/2000/svg' width='900mm' height='9mm' viewBox='0 0 900 9'><path d='M0 0L900 9'/></svg>", &[], "--fit"),
        ("far.svg", b"<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm' viewBox='0 0 9 9'><path d='M0 0L9 9'/></svg>", &["--plate", "2000x2000", "--fit"], "does not reach"),
        ("some.xyz", b"hello", &[], "some.xyz"),
    ];
    for (name, content, arguments, expected) in cases {
        let folder = folder(name);
        std::fs::write(folder.join(name), content).expect("the folder can be written");
        let output = engraving(&folder, &[&[name], arguments].concat());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{name}: {errors}");
        assert!(errors.contains(expected), "{name}: {errors}");
        assert!(!folder.join("engraving").exists(), "{name} left results");
    }
}

#[test]
fn an_option_that_does_not_exist_gets_a_suggestion() {
    let folder = folder("options");
    let output = engraving(&folder, &["--dept", "1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--depth"));
}

#[test]
fn fault_70_a_drawing_is_not_overwritten_by_its_own_results() {
    let folder = folder("own");
    let out = folder.join("engraving");
    std::fs::create_dir_all(&out).expect("the folder can be written");
    let drawing = "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm' viewBox='0 0 9 9'><path d='M0 0L9 9'/></svg>";
    std::fs::write(out.join("paths.svg"), drawing).expect("the folder can be written");
    for more in [&[][..], &["--virtual"]] {
        let output = engraving(&folder, &[&["engraving/paths.svg", "--quiet"], more].concat());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains("which this run reads: it is not overwritten"), "{errors}");
        assert_eq!(std::fs::read_to_string(out.join("paths.svg")).expect("it is there"), drawing);
    }
    // A recording is refused alike.
    let output =
        engraving(&folder, &["engraving/paths.svg", "--out", "other", "--record", "engraving/paths.svg"]);
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(out.join("paths.svg")).expect("it is there"), drawing);
}
