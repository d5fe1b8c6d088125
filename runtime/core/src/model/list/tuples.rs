//! Lists of robots of mixed kinds: tuples.

use crate::model::image::RobotImage;
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::wire::{BadWords, Wire};

use super::robots::{
    AnyRobots, Language, ListOf, Owner, PayloadType, RobotHandle, RobotList, Robots, RobotsEach, RobotsOf,
    poses,
};

macro_rules! tuple_lists {
    ($($len:literal: $($R:ident $i:tt),+;)*) => {$(
        impl<$($R: Robot),+> RobotList for ($($R,)+) {
            const LEN: usize = $len;
            type Images = ($(RobotImage<$R>,)+);

            fn unknown() -> Self::Images {
                ($(RobotImage::<$R>::unknown(),)+)
            }

            fn read(images: &mut Self::Images, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => images.$i = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }

            type Each<T: Copy> = [T; $len];

            fn array<T: Copy>(value: impl FnMut(usize) -> T) -> [T; $len] {
                core::array::from_fn(value)
            }

            fn poses(images: &Self::Images) -> [(Pose, Pose); $len] {
                [$(poses(&images.$i)),+]
            }
        }

        impl<T, O, $($R: Robot),+> RobotsEach<T, O> for ($($R,)+)
        where
            $(O: Language<$R>, T: Into<<O as Language<$R>>::Item>,)+
        {
            fn each(mut told: impl FnMut(usize) -> T) -> Self::Demands {
                ($(told($i).into(),)+)
            }
        }

        impl<O, $($R: Robot),+> Robots<O> for ($($R,)+)
        where
            $(O: Language<$R>,)+
        {
            type Demands = ($(<O as Language<$R>>::Item,)+);

            fn write(demands: &Self::Demands, i: usize, words: &mut [u64]) -> usize {
                match i {
                    $($i => {
                        demands.$i.put(words);
                        demands.$i.used()
                    })+
                    _ => 0,
                }
            }

            fn payload(i: usize) -> PayloadType {
                match i {
                    $($i => PayloadType::of::<<O as Language<$R>>::Item>(),)+
                    _ => PayloadType::of::<()>(),
                }
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),+> ListOf<($($R,)+)> for ($(&mut RobotHandle<$R>,)+) {}

        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),+> RobotsOf<($($R,)+)> for ($(&mut RobotHandle<$R>,)+) {
            type Indices = [usize; $len];

            fn indices(&self) -> [usize; $len] {
                [$(self.$i.index),+]
            }

            fn stranger(&self, owner: Owner) -> Option<Name> {
                None$(.or_else(|| owner.not_its_own(self.$i.owner, self.$i.name)))+
            }

            fn images(&self) -> ($(RobotImage<$R>,)+) {
                ($(self.$i.image,)+)
            }

            fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => self.$i.image = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }
        }

        #[diagnostic::do_not_recommend]
        impl<$($R: Robot),+> RobotsOf<AnyRobots> for ($(&mut RobotHandle<$R>,)+) {
            type Indices = [usize; $len];

            fn indices(&self) -> [usize; $len] {
                [$(self.$i.index),+]
            }

            fn stranger(&self, owner: Owner) -> Option<Name> {
                None$(.or_else(|| owner.not_its_own(self.$i.owner, self.$i.name)))+
            }

            fn images(&self) {}

            fn refresh(&mut self, i: usize, words: &[u64]) -> Result<(), BadWords> {
                match i {
                    $($i => self.$i.image = RobotImage::get(words)?,)+
                    _ => {}
                }
                Ok(())
            }
        }
    )*};
}

tuple_lists! {
    1: A 0;
    2: A 0, B 1;
    3: A 0, B 1, C 2;
    4: A 0, B 1, C 2, D 3;
    5: A 0, B 1, C 2, D 3, E 4;
    6: A 0, B 1, C 2, D 3, E 4, F 5;
    7: A 0, B 1, C 2, D 3, E 4, F 5, G 6;
    8: A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7;
}
