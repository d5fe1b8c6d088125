//! What a client asks, when it asks again, and what it takes for an answer.

use super::*;
use instrument::VirtualLine;

/// The outcome of a sight, and the line that it went over.
fn sight<'t>(
    spoil: impl FnMut(usize, String) -> Vec<String> + Send + 't,
) -> (Result<Measured, GeocomError>, VirtualLine<'t>) {
    let mut line = line_to(spoil);
    let mut client = Client::new(Timeouts::default());
    client.sight([0.702, -0.301], Face::Two);
    let outcome = line.run(&mut client);
    (outcome.map(|measured| measured.expect("a measurement")), line)
}

fn busy(answer: &str) -> String {
    let answer = Answer::parse(answer).expect("an answer");
    Answer { code: Code(1293), values: Vec::new(), ..answer }.to_string()
}

#[test]
fn the_mean_of_both_faces_is_free_of_the_errors_of_the_axes() {
    let mut line = line_to(|_, answer| vec![answer]);
    let mut client = Client::new(Timeouts::default());
    client.greet();
    assert_eq!(line.run(&mut client), Ok(None));
    let [one, two] = [Face::One, Face::Two].map(|face| {
        client.sight([0.702, -0.301], face);
        let measured = line.run(&mut client).expect("a sight").expect("a measurement");
        assert_eq!(measured.face, face);
        measured.angles
    });
    let [c, i, v0] = AXES;
    let off = c / DIRECTION[1].cos() + i * DIRECTION[1].tan();
    assert!((one[0] - DIRECTION[0] - off).abs() < 1e-12 && (one[1] - DIRECTION[1] - v0).abs() < 1e-12);
    for axis in 0..2 {
        assert!((0.5 * (one[axis] + two[axis]) - DIRECTION[axis]).abs() < 1e-12);
    }
}

#[test]
fn fault_182_what_the_instrument_says_of_itself_is_no_reading_and_says_what_to_do() {
    let told = |outcome: Result<Option<Measured>, GeocomError>| outcome.expect_err("no reading").to_string();
    let mut line = line_to(|_, answer| vec![answer]);
    line.instrument.simulated.is_level = false;
    let mut client = Client::new(Timeouts::default());
    client.measure();
    assert!(told(line.run(&mut client)).contains("level the instrument"));
    // Once, and not three times: it would say the same.
    assert_eq!(line.instrument.asked, 1);
    let mut line = line_to(|_, answer| vec![answer]);
    let mut client = Client::new(Timeouts::default());
    client.sight([2.0, 0.0], Face::One);
    let why = told(line.run(&mut client));
    assert!(why.contains("8710") && why.contains("is the line of sight free"), "{why}");
    // The next sight is one like any other.
    client.sight([0.7, -0.3], Face::One);
    assert!(line.run(&mut client).is_ok());
}

#[test]
fn fault_183_silence_garbled_lines_and_a_busy_instrument_are_asked_again_three_times_in_all() {
    let (undisturbed, line) = sight(|_, answer| vec![answer]);
    // The face, a turn over, the face again, a turn, a measurement.
    let questions = line.instrument.asked;
    assert_eq!(questions, 5);
    for question in 0..questions {
        // Twice in a row any question fails, by each kind of failure.
        for failure in 0..4 {
            let spoilt = |asked: usize, answer: String| match failure {
                _ if !(question..question + 2).contains(&asked) => vec![answer],
                0 => vec![],
                1 => vec![answer.replace("%R1P", "%R!P")],
                2 => vec![answer[..answer.len() / 2].to_owned()],
                _ => vec![busy(&answer)],
            };
            let (read, line) = sight(spoilt);
            let (read, undisturbed) = (read.expect("a sight"), undisturbed.expect("a sight"));
            assert_eq!(read.face, undisturbed.face);
            assert!((read.angles[0] - undisturbed.angles[0]).abs() < 1e-12, "{question} {failure}");
            // A turn over of which no answer came is asked for no more where the face says that it is done.
            let asked = line.instrument.asked;
            assert!(
                asked == questions + 2 || question < 2 && asked == questions + 1,
                "{question} {failure}: {asked}"
            );
        }
    }
    let always = |spoilt: &(dyn Fn(&str) -> Vec<String> + Sync)| {
        let (outcome, line) = sight(|_, answer| spoilt(&answer));
        (outcome, line.instrument.asked)
    };
    assert_eq!(always(&|_| vec![]), (Err(GeocomError::Silent), 3));
    assert_eq!(always(&|_| vec!["%R1P,0".to_owned()]), (Err(GeocomError::Garbled), 3));
    assert_eq!(always(&|answer| vec![busy(answer)]), (Err(GeocomError::Refused(Code(1293))), 3));
}

#[test]
fn fault_183_silence_lasts_three_seconds_for_each_of_three_questions_and_thirty_where_it_turns() {
    let (outcome, line) = sight(|_, _| vec![]);
    assert_eq!((outcome, line.now), (Err(GeocomError::Silent), MS(9000)));
    assert_eq!(line.instrument.times, [MS(0), MS(3000), MS(6000)]);
    // The face, a turn over and the face again are answered 40 ms after they were asked for; the turn to the target is not.
    let (outcome, line) = sight(|asked, answer| if asked < 3 { vec![answer] } else { vec![] });
    assert_eq!((outcome, line.now), (Err(GeocomError::Silent), MS(3 * 40 + 90_000)));
    assert_eq!(line.instrument.times[3..], [MS(120), MS(30_120), MS(60_120)]);
}

#[test]
fn fault_183_an_answer_that_comes_when_the_time_is_over_is_read_if_it_is_there_and_asked_again_if_not() {
    // Its second half comes 10 ms after the first one. One that is late is not that of the second question, which comes as late, but begins its time anew.
    for (takes, asked, end) in [(2990, 1, 3000), (2991, 2, 6001)] {
        let mut line = line_to(|_, answer| vec![answer]);
        line.instrument.takes = MS(takes);
        let mut client = Client::new(Timeouts { times: 2, ..Timeouts::default() });
        client.greet();
        assert_eq!((line.run(&mut client), line.now), (Ok(None), MS(end)));
        assert_eq!(line.instrument.asked, asked);
    }
}

#[test]
fn fault_183_a_line_that_takes_nothing_is_tried_for_two_seconds_each_time() {
    let mut line = line_to(|_, answer| vec![answer]);
    line.is_taken = false;
    let mut client = Client::new(Timeouts::default());
    client.greet();
    assert_eq!((line.run(&mut client), line.now), (Err(GeocomError::Silent), MS(6000)));
    assert!(client.outgoing().is_empty(), "a question of which nobody waits for the answer is not sent");
    line.is_taken = true;
    client.greet();
    assert_eq!(line.run(&mut client), Ok(None));
}

#[test]
fn fault_184_an_answer_to_an_earlier_question_is_never_taken() {
    // The answer to one question comes only with that to the next.
    for late in 0..4 {
        let mut kept = None;
        let (read, _) = sight(|asked, answer| {
            if asked == late {
                kept = Some(answer);
                return vec![];
            }
            kept.take().into_iter().chain([answer]).collect()
        });
        let (undisturbed, _) = sight(|_, answer| vec![answer]);
        assert_eq!(read, undisturbed, "{late}");
    }
}

#[test]
fn fault_184_a_telescope_whose_turn_is_not_answered_is_not_turned_back() {
    // The second question turns it over.
    let (read, _) = sight(|asked, answer| if asked == 1 { vec![] } else { vec![answer] });
    assert_eq!(read.map(|read| read.face), Ok(Face::Two));
}

#[test]
fn what_came_before_a_question_is_no_answer_to_it() {
    let mut client = Client::new(Timeouts::default());
    client.greet();
    // An answer of the right number that is there before the question, in two pieces, and one whose end comes after it.
    assert_eq!(client.poll(MS(0), b"%R1P,0,1"), ClientAction::Receive { until: MS(0) });
    assert_eq!(client.poll(MS(1), b":27\r\n%R1P"), ClientAction::Receive { until: MS(1) });
    assert_eq!(client.poll(MS(1), b""), ClientAction::Send { until: MS(2001) });
    let question = String::from_utf8(client.outgoing().to_vec()).expect("text");
    assert!(question.starts_with("%R1Q,0,1,") && question.ends_with(":\r\n"), "{question}");
    client.sent(question.len());
    // The rest of the older line makes one that cannot be understood: it is asked again, with the next number.
    assert_eq!(client.poll(MS(5), b"!\r\n"), ClientAction::Receive { until: MS(5) });
    assert_eq!(client.poll(MS(5), b""), ClientAction::Send { until: MS(2005) });
    assert!(client.outgoing().starts_with(b"%R1Q,0,2,"));
}

#[test]
fn an_instrument_that_never_stops_talking_is_no_instrument() {
    let line = "%R1P,0,7:0\r\n";
    let mut client = Client::new(Timeouts { times: 1, ..Timeouts::default() });
    client.greet();
    assert_eq!(client.poll(MS(0), line.repeat(64).as_bytes()), ClientAction::Receive { until: MS(0) });
    assert_eq!(client.poll(MS(0), line.as_bytes()), ClientAction::Done(Err(GeocomError::Garbled)));
    // Answers to other questions: each of them begins the time anew, and the eighth is the last.
    client.greet();
    assert_eq!(client.poll(MS(0), b""), ClientAction::Receive { until: MS(0) });
    assert_eq!(client.poll(MS(0), b""), ClientAction::Send { until: MS(2000) });
    client.sent(client.outgoing().len());
    assert_eq!(client.poll(MS(0), b""), ClientAction::Receive { until: MS(3000) });
    for count in 1..8 {
        let now = MS(2000 * count);
        assert_eq!(client.poll(now, line.as_bytes()), ClientAction::Receive { until: now + MS(3000) });
    }
    assert_eq!(client.poll(MS(16_000), line.as_bytes()), ClientAction::Done(Err(GeocomError::Silent)));
}
