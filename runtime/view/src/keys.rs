//! The keys of the view.
//!
//! In: a key, and the speed that is set. Out: the request to the cell, if the key means one.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use mrroc_core::operator::button::Button;
use mrroc_processes::Request;

/// The list of the keys, for the screen.
pub(super) const KEYS: &str = "space stop · a abort · s suspend · r resume · + − speed · t take · l let go · k acknowledge · e reset · q quit";

/// Number of notches from 0 to full speed: `+` and `-` change the speed by one notch, a tenth.
const NOTCHES: f64 = 10.0;

/// What a key means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pressed {
    Ask(Request),
    Quit,
    Nothing,
}

/// What a key means while this speed is set, 0 to 1.
pub(super) fn meaning(key: KeyEvent, speed: f64) -> Pressed {
    let press = |button| Pressed::Ask(Request::Press(button));
    let notch = |notch: f64| press(Button::Speed(notch.clamp(0.0, NOTCHES) / NOTCHES));
    // 1e-9 is far less than a notch and far more than the rounding error of a speed, so that 0.3 counts as the third
    // notch.
    let (last, next) = ((NOTCHES * speed + 1e-9).floor(), (NOTCHES * speed - 1e-9).ceil());
    match key.code {
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => Pressed::Quit,
        KeyCode::Char('q') => Pressed::Quit,
        KeyCode::Char(' ') => press(Button::Stop),
        KeyCode::Char('a') => press(Button::Abort),
        KeyCode::Char('s') => press(Button::Suspend),
        KeyCode::Char('r') => press(Button::Resume),
        KeyCode::Char('+' | '=') | KeyCode::Up => notch(last + 1.0),
        KeyCode::Char('-') | KeyCode::Down => notch(next - 1.0),
        KeyCode::Char('t') => Pressed::Ask(Request::Take),
        KeyCode::Char('l') => Pressed::Ask(Request::Release),
        KeyCode::Char('k') => press(Button::Acknowledge),
        KeyCode::Char('e') => press(Button::Reset),
        _ => Pressed::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_ask_for_what_the_screen_says_they_do() {
        let key = |letter| KeyEvent::new(KeyCode::Char(letter), KeyModifiers::NONE);
        for (letter, button) in [
            (' ', Button::Stop),
            ('a', Button::Abort),
            ('s', Button::Suspend),
            ('r', Button::Resume),
            ('k', Button::Acknowledge),
            ('e', Button::Reset),
        ] {
            assert_eq!(meaning(key(letter), 1.0), Pressed::Ask(Request::Press(button)));
        }
        assert_eq!(meaning(key('t'), 1.0), Pressed::Ask(Request::Take));
        assert_eq!(meaning(key('q'), 1.0), Pressed::Quit);
        let control_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!((meaning(control_c, 1.0), meaning(key('c'), 1.0)), (Pressed::Quit, Pressed::Nothing));
    }

    #[test]
    fn the_speed_changes_by_tenths_and_stays_a_speed() {
        let speed =
            |letter, from| match meaning(KeyEvent::new(KeyCode::Char(letter), KeyModifiers::NONE), from) {
                Pressed::Ask(Request::Press(Button::Speed(speed))) => speed,
                other => panic!("{other:?}"),
            };
        for (letter, from, to) in [
            ('+', 0.3, 0.4),
            ('-', 0.3, 0.2),
            ('+', 1.0, 1.0),
            ('-', 0.0, 0.0),
            ('-', 0.25, 0.2),
            ('+', 0.95, 1.0),
        ] {
            assert_eq!(speed(letter, from), to, "{letter} from {from}");
        }
    }
}
