//! Trajectories that other nodes have the robots follow: the action `control_msgs/FollowJointTrajectory`, of each robot, and of any of them as one goal.

mod goals;
mod messages;
mod playback;
mod request;
#[cfg(test)]
mod tests;

use mrroc_core::console::complain;
use mrroc_core::observe::layout::Layout;
use mrroc_external::goals::Goals as GoalSensor;
use mrroc_external::{Image, Sender, State, monotonic};
use ros2_client::RmwRequestId;
use ros2_client::action::{ActionServer, GetResultResponse, SendGoalResponse};
use ros2_client::action_msgs::{GoalId, GoalInfo, GoalStatusArray, GoalStatusEnum};
use ros2_client::builtin_interfaces::Time;
use serde::Deserialize;

use crate::clock::now;
use crate::messages::Stamp;
use crate::node::{RosNode, topic_name};
use crate::outlet::Outlet as _;
use goals::{Goals, Now, Told};
pub use messages::{Duration, MultiTrajectory, Point, Request, Trajectory};
use messages::{Feedback, Outcome};
use playback::Playback;
use request::Offered;

type Server = ActionServer<Request, Outcome, Feedback>;

/// Requests of each kind that are taken at a time, however many come: the rest has its turn.
const EACH: usize = 10;

/// Results that are waited for at a time.
const WAITING: usize = 1000;

/// The action servers, and what they serve.
pub struct Trajectories {
    /// Each for one robot of the layout, or for any.
    servers: Vec<(Option<usize>, Server)>,
    goals: Goals,
    sensor: Sender<GoalSensor>,
    /// Who waits for the result of which goal.
    asked: Vec<(usize, RmwRequestId, GoalId)>,
    robots: Vec<Option<Now>>,
    fault: Option<String>,
    /// Goals of a bag.
    playback: Option<Playback>,
    /// Whether it was told that the cell is of another version.
    told: bool,
}

/// Finds out whether robots of a layout and a node of this name can each have an action.
///
/// # Errors
/// Why not.
pub fn check_actions(layout: &Layout, node: &str) -> Result<(), String> {
    match layout.robots.iter().find(|robot| topic_name(&robot.name) == node) {
        None => Ok(()),
        Some(robot) => Err(format!(
            "robot `{}` and the node would have the same action\n help: give the node another name by --node",
            robot.name
        )),
    }
}

/// What is wrong with goals of a bag: names of joints, times, tolerances; and limits. How the robots begin is known of a goal whose first
/// point is at time 0, since robots that are elsewhere are refused, and of one that says that they rest at its first point; of any other one the way from the first point on
/// is looked at.
pub fn mistakes(
    layout: &Layout,
    joints: Vec<Vec<String>>,
    goals: &[Request],
    only: Option<usize>,
) -> Vec<String> {
    let offered = Offered { layout: layout.clone(), joints };
    let check = |goal: &Request| {
        let asked = offered.read(goal, only, now())?;
        let Some(first) = asked.goal.trajectory.points().first() else { return Ok(()) };
        let rests = !first.velocities.is_empty() && first.velocities.iter().all(|&velocity| velocity == 0.0);
        match rests || first.time == 0.0 {
            true => offered.check(&asked, &first.positions),
            false => offered.check_onwards(&asked),
        }
    };
    let wrong = |(place, goal)| {
        let why = check(goal).err()?;
        Some(format!("bag: trajectory {}: {}", place + 1, why.error_string))
    };
    goals.iter().enumerate().filter_map(wrong).collect()
}

/// A cancellation, whose fields `ros2-client` does not let others see.
#[derive(Deserialize)]
struct Cancellation {
    goal_info: GoalInfo,
}

impl Trajectories {
    /// For the program of the cell that has a sensor of goals at this port, and robots of a layout, whose joints have these names.
    ///
    /// # Errors
    /// Why that cannot be.
    pub fn at(port: &str, layout: &Layout, joints: Vec<Vec<String>>) -> Result<Trajectories, String> {
        Ok(Trajectories {
            servers: Vec::new(),
            robots: vec![None; layout.robots.len()],
            goals: Goals::new(Offered { layout: layout.clone(), joints }),
            sensor: Sender::at(port)?,
            asked: Vec::new(),
            fault: None,
            playback: None,
            told: false,
        })
    }

    /// Offers the robots to other nodes.
    ///
    /// # Errors
    /// Why that cannot be.
    pub fn offer(&mut self, node: &mut RosNode, layout: &Layout) -> Result<(), String> {
        for (robot, of) in layout.robots.iter().enumerate() {
            let name = format!("/{}/follow_joint_trajectory", topic_name(&of.name));
            self.servers.push((Some(robot), node.action(&name, ("control_msgs", "FollowJointTrajectory"))?));
        }
        let of_all = node.own("follow_joint_trajectory");
        self.servers.push((None, node.action(&of_all, ("control_msgs", "FollowJointTrajectory"))?));
        Ok(())
    }

    /// Has the robots follow goals of a bag, all for one robot or each for those that it names.
    pub fn play(&mut self, goals: Vec<Request>, only: Option<usize>) {
        self.playback = Some(Playback::of(goals, only));
    }

    /// What a robot does in a step, and the step's stamp.
    pub fn image(&mut self, image: &Image, stamp: Stamp) {
        let state = |state: &State| [state.joints.clone(), state.velocity.clone()];
        if let Some(robot) = self.robots.get_mut(image.robot) {
            *robot = Some(Now { stamp, demanded: state(&image.demanded), measured: state(&image.measured) });
        }
    }

    /// What has stopped the cell, if anything has.
    pub fn fault(&mut self, fault: Option<&str>) {
        self.fault = fault.map(str::to_owned);
    }

    /// Takes what has come from nodes and from the cell, and tells them what there is to tell; waits for nobody.
    pub fn serve(&mut self) {
        self.hear();
        self.play_on();
        let told = self.goals.advance(monotonic(), &self.robots, self.fault.as_deref());
        self.tell(told);
        self.sensor.send_now(&self.goals.news());
    }

    /// Takes what other nodes and the cell say. A request that cannot be read is another node's fault, and is not answered.
    fn hear(&mut self) {
        for (place, (only, server)) in self.servers.iter().enumerate() {
            for _ in 0..EACH {
                let Ok(Some((request, asked))) = server.receive_goal() else { break };
                let times = [monotonic(), now()];
                let accepted = self.goals.request(place, *only, asked.goal_id, &asked.goal, times);
                let stamp = Time::from_nanos(times[1].cast_signed());
                drop(server.send_goal_response(request, SendGoalResponse { accepted, stamp }));
            }
            for _ in 0..EACH {
                let Ok(Some((request, cancellation))) = server.receive_cancel_request() else { break };
                let read =
                    serde_json::to_value(cancellation).and_then(serde_json::from_value::<Cancellation>);
                let Ok(Cancellation { goal_info }) = read else { continue };
                drop(server.send_cancel_response(request, self.goals.cancel(place, &goal_info)));
            }
            for _ in 0..EACH {
                let Ok(Some((request, asked))) = server.receive_result_request() else { break };
                // Who asks again and again is not answered each time.
                if self.asked.len() < WAITING {
                    self.asked.push((place, request, asked.goal_id));
                }
            }
        }
        match self.sensor.order() {
            Ok(Some(state)) => self.goals.hear(state, monotonic()),
            Ok(None) => {}
            Err(why) if !self.told => {
                self.told = true;
                complain(&format!("warning: trajectories are not served: {why}"));
            }
            Err(_) => {}
        }
    }

    /// Goes on with the goals of a bag, whose place is behind those of the servers.
    fn play_on(&mut self) {
        let Some(playback) = &mut self.playback else { return };
        if let Some(id) = playback.at_work() {
            match self.goals.result(id) {
                Ok(None) => {}
                Ok(Some((status, outcome))) => playback.ended(status, &outcome),
                Err(()) => {
                    let error_string = "what became of it is not known any more".to_owned();
                    playback.ended(GoalStatusEnum::Unknown, &Outcome { error_string, ..Outcome::default() });
                }
            }
        }
        let times = [monotonic(), now()];
        let is_ready =
            self.fault.is_none() && self.goals.is_heard(times[0]) && self.robots.iter().all(Option::is_some);
        if let Some((id, goal)) = playback.next(times[0], is_ready)
            && !self.goals.request(self.servers.len(), playback.only, id, &goal, times)
        {
            let why = Outcome { error_string: "too many goals are at work".to_owned(), ..Outcome::default() };
            playback.ended(GoalStatusEnum::Aborted, &why);
        }
    }

    /// Tells other nodes; the goals of a bag are none of theirs.
    fn tell(&mut self, told: Told) {
        for (place, id, feedback) in told.feedback {
            if let Some((_, server)) = self.servers.get(place) {
                drop(server.send_feedback(id, feedback));
            }
        }
        for (place, status_list) in told.statuses {
            if let Some((_, server)) = self.servers.get(place) {
                drop(server.send_goal_statuses(GoalStatusArray { status_list }));
            }
        }
        let (goals, servers) = (&self.goals, &self.servers);
        self.asked.retain(|(place, request, id)| {
            let (status, result) = match goals.result(*id) {
                Ok(None) => return true,
                Ok(Some(ended)) => ended,
                Err(()) => (GoalStatusEnum::Unknown, Outcome::default()),
            };
            drop(servers[*place].1.send_result(*request, GetResultResponse { status, result }));
            false
        });
    }
}
