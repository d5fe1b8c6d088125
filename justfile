# Mirrors CI; the README's two commands need none of it.

# What CI runs: the tests, the linters, where there is time the tests with checks of overflow, and the peers whose crates have changed since a commit.
ci COMMIT="":
    .ci/run {{COMMIT}}

# What compares with software of others: all of it, or what has changed since a commit, or with `--passed` since each passed; `--record` writes down what passes.
peers *ARGS:
    .ci/peers {{ARGS}}

# The tests that need the machine's clock, so many times, none of them again because it failed: how many passed, and how cells ended.
real-time N="30":
    tests/real_time {{N}}

# Whether rustc drops a comparison that is read, in all crates of the lock file (decision 24): release code, from clean.
dropped-comparisons:
    RUSTC_WRAPPER="$PWD/.ci/dropped-comparisons" cargo build --release --workspace --exclude mrroc-zenoh --exclude mrroc-ros2 --target-dir target/dropped-comparisons

# Recordings of release builds replayed by builds with checks and little optimisation, and the other way round, so many of each task.
recordings N="20":
    cargo build --config .ci/checked.toml -p engraving -p transfer -p maze -p sorting -p legs --features mrroc/recording --bins
    cargo build --release -p engraving -p transfer -p maze -p sorting -p legs --features mrroc/recording --bins
    .ci/recordings {{N}} target/debug target/release

# The pictures on the tasks' pages anew, from the programs that `cargo test` compiles: look at them.
pictures:
    cargo build -p maze -p legs --bins
    .ci/pictures target/debug --accept
    cargo test -p mrroc-generators --lib -- --ignored draw_all_pictures_anew

# The crates that make demands, and all that reads files, with checks of overflow, which release's code has not.
test-checked:
    cargo test --config .ci/checked.toml -p mrroc-core -p mrroc-generators -p mrroc-robots -p mrroc-recording --tests
    cargo test --config .ci/checked.toml -p mrroc-tests --test all -- parsers recording allocation safety::sweeps

# All tests but those of `mrroc-new`.
test:
    cargo test

# Those of `mrroc-new`: the projects and copies that it makes.
test-new:
    tests/peers/new/run

# All tests by cargo-nextest, which runs those of all executables at once; doc tests are not among them.
nextest:
    cargo nextest run

# Every project that the template can make: its tests, clippy and formatting. Takes minutes.
template-all:
    cargo test -p mrroc-new --test all -- --ignored --nocapture projects_of_all_choices

# What a step costs, in nanoseconds.
bench:
    cargo bench -p mrroc-benches --bench steps
    cargo bench -p mrroc-generators --bench generators
    cargo bench -p mrroc-generators --bench jerk
    cargo bench -p mrroc-robots --bench kinematics

# What an attached panel costs the processes that move robots: lateness in alternating runs, system calls for each step.
bench-panel ROUNDS="5":
    cargo build --release -p mrroc-examples --features panel --examples
    python3 tests/benches/peers/panel.py target/release/examples/to_and_fro ports/panel/examples/cell.toml {{ROUNDS}}

# What the bridge to ROS 2 costs a cell of four arms: lateness in alternating runs, joint states that rclpy misses, system calls in a second.
bench-ros2 ROUNDS="3" SECONDS="60":
    tests/peers/ros2/run cost {{ROUNDS}} {{SECONDS}}

# The instructions of a step with the bridge to ROS 2 and without it; needs valgrind.
instructions-ros2:
    tests/peers/ros2/run instructions

# How soon an arm stands that is jogged in a browser: so many holds of each way to end one, tested from recordings. A quarter of an hour.
test-panel-holds N="100":
    tests/peers/panel/run holds --times {{N}}

# Instructions of a step and of its parts, beside their tables: optimised, and as CI counts them; `--accept` writes both anew.
instructions *ARGS:
    cargo run --release -p mrroc-benches --example instructions -- {{ARGS}}
    CARGO_INCREMENTAL=0 cargo test --no-run
    .ci/instructions {{ARGS}}

# What profiles and jerk-limited plans keep, for 256,000 random inputs of each kind.
sweep-profiles:
    cargo test --release -p mrroc-generators --lib -- --ignored properties::whole::

# Inverse kinematics of all robots in release: 100,000 poses of those in closed form, 10,000 of those from a URDF.
test-inverse:
    cargo test --release -p mrroc-robots --test all -- inverse_returns urdf_inverse urdf_closed --nocapture

# The planner beside VAMP on MotionBenchMaker's problems, and its paths on the robots' meshes by coal: compiles VAMP, takes half an hour.
compare-planners *ARGS:
    tests/peers/planning/compare {{ARGS}}

# Plans of arms whose links are meshes, and stops from them, checked by coal on the meshes: a share as CI runs it, or more by --every, --seeds and --stops.
check-plans *ARGS:
    tests/peers/planning/run {{ARGS}}

# Distances of two arms from meshes beside coal on the same capsules, in one run.
compare-distances:
    tests/peers/planning/distances

# Plans of two and of four arms across each other, so many of each kind: how many are solved within a second, and in what time.
bench-arms SEEDS="100":
    cargo bench -p mrroc-planning --bench arms -- {{SEEDS}}

# Many queries in one world, with a roadmap of the queries before and without, so many of each kind in so many worlds.
bench-queries WORLDS="3" QUERIES="60":
    cargo bench -p mrroc-planning --bench queries -- {{WORLDS}} {{QUERIES}}

# Stops of two arms on plans of many seeds: a million states of the processes' own stops, none nearer than the margin.
sweep-plans:
    cargo test --release -p mrroc-planning --lib -- --ignored --nocapture a_million_states

# A guard that knows its plan, asked in every step of so many plans of each of three kinds: how many it stops. Hours, most of them for planning two arms.
sweep-guard PLANS="3334":
    MRROC_PLANS={{PLANS}} cargo test --release -p mrroc-planning --lib -- --ignored --nocapture a_guard_is_silent_on_thousands

# Two arms that follow one trajectory of joint positions, cancelled, suspended, stopped and ended by a fault at a thousand instants each.
sweep-goals:
    cargo test --release -p mrroc-generators --lib -- --ignored --nocapture at_a_thousand_instants

# The memory that a spline of ten million points takes; `cargo test` takes one million.
test-memory:
    cargo test --release -p mrroc-generators --lib -- memory

# Kinematics beside KDL, Pinocchio and rs-opw-kinematics, motions beside KDL and Ruckig, all installed into target/peers.
bench-peers:
    tests/benches/peers/run
    tests/benches/peers/timing
    tests/benches/peers/motions

# Accept changed snapshots of expansions, diagnostics and the template's files.
snapshots:
    INSTA_UPDATE=always cargo test -p mrroc-macros
    INSTA_UPDATE=always cargo test -p mrroc-tests --test all macros::diagnostics
    INSTA_UPDATE=always cargo test -p mrroc-new --test all every_combination_has_its_files

# Engrave the drawing that is shipped with the project.
engrave *ARGS:
    cargo run --release -- {{ARGS}}

# The tutorial and the tables for those who come from elsewhere, as a book: target/book/index.html.
book:
    mdbook build docs

# Recordings and their replay; the second one reads a recording back with PyPI's mcap.
test-recording:
    cargo test -p mrroc-tests --test all recording::

test-recording-peer: test-recording
    cargo test -p mrroc-tests --test all -- --ignored --nocapture another_librarys_values

# Cells as processes of the operating system.
test-processes:
    cargo test -p mrroc-tests --test processes

# The same, with 200 kills of each process in lock-step, and as many in real time; takes hours.
test-kills KILLS="2000":
    MRROC_KILLS={{KILLS}} cargo test --release -p mrroc-tests --test processes -- --nocapture fault_01_to fault_07

# Parts on a belt: one for each of 1,000 seeds, over all speeds, beside open loop; the table and sorting/scatter.svg.
sorting-whole SEEDS="1000":
    cargo run --release -p sorting -- --sweep {{SEEDS}}
    cargo test --release -p sorting --lib -- --ignored --nocapture whole:: --skip two_arms:: --skip matrix

# Mazes by touch, by force, by a camera, without a map and by wheels: all by chance that tests know, in release; takes tens of minutes.
maze-whole:
    cargo test --release -p maze --lib -- --ignored --nocapture whole::

# All mazes of a folder by each means, and by a ball that touches exactly, without an arm; such as contests' mazes, which are not in the tree.
maze-sweep DIR:
    MRROC_MAZES={{DIR}} cargo test --release -p mrroc-map --lib -- --ignored --nocapture mazes_of_a_folder
    cargo run --release -p maze -- --sweep {{DIR}}
    cargo run --release -p maze -- --sweep {{DIR}} --sensor force
    cargo run --release -p maze -- --sweep {{DIR}} --sensor camera
    cargo run --release -p maze -- --sweep {{DIR}} --controller reactive
    cargo run --release -p maze -- --sweep {{DIR}} --effector wheels

# Parts on a belt in long runs, by each sensor and by two arms: so many of 20 seeds from FIRST on, 500 parts each, at 0.02 to 0.15 m/s; what came of each. Hours: runs that are in
# TABLE are not made again.
sorting-long SEEDS="20" FIRST="7000" TABLE="target/sorting-runs.csv":
    MRROC_SEEDS={{SEEDS}} MRROC_FIRST_SEED={{FIRST}} MRROC_TABLE="$PWD/{{TABLE}}" cargo test --release -p sorting --lib -- --ignored --nocapture --test-threads 1 long::

# Parts on a belt below a camera: so many at each of three speeds and three arrival rates, and recognition of others; sorting/scatter.svg.
sorting-camera PARTS="500":
    cargo run --release -p sorting -- --sensor camera --sweep {{PARTS}}
    cargo run --release -p sorting -- --sensor camera --examine 2400

# Two arms at one belt: so many parts at three arrival rates, each miss explained.
sorting-two-arms PARTS="500":
    cargo run --release -p sorting -- --sensor camera --arms 2 --sweep {{PARTS}} --speeds 0.1
    cargo test --release -p sorting --lib -- --ignored --nocapture two_arms::whole::

# Parts on a belt below an ultrasonic matrix: recognition of others, faults, runs at three speeds; minutes.
sorting-matrix:
    cargo test --release -p sorting --lib -- --ignored --nocapture matrix::whole:: matrix_faults::whole::
    cargo run --release -p sorting -- --sensor ultrasonic --examine 2250

# Trains the network of the sorting task's matrix anew; needs PyPI's numpy, scikit-learn and onnx.
sorting-train-matrix:
    cargo run --release -p sorting -- --sensor ultrasonic --data-set target/reliefs.csv --parts 3700 --seed 101
    python3 sensing/training/train.py target/reliefs.csv tasks/sorting/assets/reliefs.onnx

# Trains the network of the sorting task's camera anew; needs PyPI's numpy, scikit-learn and onnx.
sorting-train:
    cargo run --release -p sorting -- --data-set target/parts.csv --parts 24000 --seed 101
    python3 sensing/training/train.py target/parts.csv tasks/sorting/assets/parts.onnx

# A hundred whole walks of the legs, and what tests ask of them.
legs-whole SEEDS="100":
    cargo run --release -p legs -- --seeds {{SEEDS}}
    cargo test --release -p legs --lib -- --ignored --nocapture whole::

# The calibration of arms for 40 and 100 seeds, of which `cargo test` takes 3: the figures of tasks/calibration/README.md.
calibration-whole:
    cargo test --release -p calibration -p mrroc-calibration -- --ignored --nocapture whole::

# All that tests try of which `cargo test` takes a share: moments of the transfer, steps of small cells, sample drawings.
test-whole:
    cargo test -p transfer -p mrroc-tests --test all -- --ignored whole:: --skip wires::
    cargo test -p engraving -- --ignored whole::

# Wires between machines that are late, lose messages and are cut: in many more steps than `cargo test` takes.
wires-whole:
    cargo test --release -p mrroc-tests --test all -- --ignored --nocapture wires::whole::
    cargo test --release -p mrroc-core --lib -- --ignored --nocapture arm_cut_off::whole::

# The engraving of the nameplate and the transfer, whole, on both links: the same demands to the bit.
test-both-links:
    cargo test --release -p mrroc-tests --test processes -- --include-ignored --nocapture both_links

# Two robots on clocks of their own, 200 ppm apart, in one motion for so many seconds of the virtual clock.
pacing SECONDS="600":
    MRROC_PACING={{SECONDS}} cargo test -p mrroc-tests --test all -- --ignored together_for_so_many_seconds

# So many launches in real time, each under a disturbance that is drawn; MRROC_SEED chooses others. Six seconds each.
launches N="200":
    MRROC_LAUNCHES={{N}} cargo test -p mrroc-tests --test processes -- --nocapture fault_87

# Two robots and a sensor as processes at 1 kHz for so many seconds, beside cyclictest: skipped steps, rate, memory.
soak SECONDS="600":
    tests/benches/peers/realtime soak {{SECONDS}}

# A whole step of 1 to 4 robots beside bare shared memory and futexes, and cyclictest, in microseconds; `all` placements
# of the processes on cores, or the launcher's.
bench-step PLACEMENTS="launcher":
    tests/benches/peers/realtime step {{PLACEMENTS}}

# A round trip between two processes beside bare iceoryx2, a futex and a socket, in microseconds.
bench-latency:
    cargo test --release -p mrroc-processes --lib round_trips_of_every_kind -- --ignored --nocapture

# Every fault in every step of small cells: over 100,000 cases, some minutes.
sweep:
    cargo test -p mrroc-tests --test all -- --ignored --nocapture every_fault_in_every_step

# Each fault in every so many steps of the transfer and of the engraving task: every 13th takes six minutes of two
# cores, every one of the engraving seven, every one of the transfer two hours.
sweep-tasks EVERY="7":
    MRROC_EVERY={{EVERY}} cargo test --release -p mrroc-tests --test all -- --ignored --nocapture of_the_engraving_and_of_the_transfer

# As many robots as a cell may have, each with its processes.
crowd:
    cargo test -p mrroc-tests --test processes sixty_four -- --ignored

# 40,000 cells with jerk limits under random operators, tested in every servo period (about eight minutes).
sweep-operators:
    cargo test -p mrroc-tests --test all random_operators -- --ignored --nocapture

# Stops on the path in every state of the robots: 15,000 cells under random operators (about four minutes).
sweep-states:
    cargo test -p mrroc-tests --test all safety::states -- --ignored --nocapture

# Faults (docs/safety) and their tests, the cases of a share of the sweeps, and the worst stop beside its bound.
safety:
    cargo test -p mrroc-tests --test all -- --ignored --nocapture safety::summary
    cargo test -p mrroc-core --lib -- --nocapture fault_03_arms fault_06_arms

# Mutated files into all that reads files and messages: so many in all, by a seed.
fuzz N="10000000" SEED="1":
    MRROC_FUZZ={{N}} MRROC_FUZZ_SEED={{SEED}} cargo test --release -p mrroc-tests --test all -- --ignored --nocapture survive_so_many_inputs

# The same with coverage, on nightly and with cargo-fuzz: a target of tests/parsers for some seconds; what it finds goes
# into tests/fuzz/corpus.
fuzz-nightly TARGET SECONDS="60":
    cd tests/fuzz && cargo +nightly fuzz run {{TARGET}} corpus/{{TARGET}} ../parsers/corpus/{{TARGET}} -- -max_total_time={{SECONDS}}

# The recordings of the corpus anew, after a change of their format.
corpus:
    cargo test -p mrroc-tests --test all -- --ignored recordings_of_this_cell_are_made_anew

# Eleven faults of limits and stops, planted one after the other: which tests catch each, with so many busy loops beside them.
planted LOAD="4":
    tests/planted --load {{LOAD}}

# Mutants of one file and the unit tests of the runtime, with cargo-mutants; takes minutes to hours.
mutants FILE="runtime/core/src/safety/stopping.rs":
    CARGO_INCREMENTAL=0 cargo mutants --in-place --file {{FILE}}

# All that the tutorial says, word for word: builds six projects, which takes minutes, and needs Python.
tutorial:
    cargo test -p mrroc-tests --test all -- --ignored --nocapture the_tutorial_works_word_for_word
