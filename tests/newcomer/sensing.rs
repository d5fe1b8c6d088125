//! A virtual sensor as it is filled in.

use mrroc::prelude::*;

pub struct Touch;

impl Sensor for Touch {
    const KIND: &'static str = "touch";
    type Reading = Contact;
    type Configuration = ();
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Contact {
    pub made: bool,
}

pub struct Table;

impl VirtualSensor for Table {
    type Kind = Touch;

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Contact, Fault> {
        Ok(Contact { made: true })
    }
}

#[condition(ecp)]
pub fn touched(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().is_some_and(|contact| contact.made)
}

/// Takes the reading for granted.
#[condition(ecp)]
pub fn unwrapped(v: &Reading<(Touch,)>) -> bool {
    v.0.reading().unwrap().made
}
