//! Disks that are full: nothing is made by halves, and what was there stays as it was.

use std::process::{Command, Output};

use crate::support::{Folder, complaint};

/// Runs a script of a shell where a file system may be mounted that nobody else sees; `None` where this user may not. The
/// program is `$1`, the folder `$2`.
fn in_mounts_of_its_own(folder: &Folder, script: &str) -> Option<Output> {
    let may = Command::new("unshare").args(["--mount", "true"]).status().is_ok_and(|status| status.success());
    if !may {
        println!("skipped: only root may mount");
        return None;
    }
    let mut command = Command::new("unshare");
    command.args(["--mount", "sh", "-c", script, "sh", env!("CARGO_BIN_EXE_mrroc-new")]).arg(folder.path());
    Some(command.current_dir(folder.path()).output().expect("it starts"))
}

#[test]
fn fault_78_a_project_on_a_disk_without_room_or_inodes_is_told_as_such() {
    for (at, limits) in
        [("into", "size=32k"), ("into", "nr_inodes=12"), ("tmp", "size=16k"), ("tmp", "nr_inodes=2")]
    {
        let folder = Folder::new();
        let script = format!(
            "mkdir into tmp && mount -t tmpfs -o {limits} tmpfs {at} && TMPDIR=\"$2/tmp\" \"$1\" my-task --into into --defaults; \
             status=$?; ls -A into tmp >left; exit $status"
        );
        let Some(output) = in_mounts_of_its_own(&folder, &script) else { return };
        let error = complaint(&output, 1);
        assert!(
            error.contains("\n help: the disk has no room left, or no inodes: "),
            "{at} {limits}: {error}"
        );
        assert!(!error.contains("fault of the template"), "{at} {limits}: {error}");
        assert_eq!(folder.read("left"), "into:\n\ntmp:\n", "{at} {limits}");
    }
}

#[test]
fn fault_78_a_generator_that_finds_no_room_leaves_the_project_as_it_was() {
    let folder = Folder::new();
    // Room for so many more pages: for none, for the copy alone, and for both the copy and the file that declares it.
    let script = "set -e; mkdir disk; mount -t tmpfs -o size=1m tmpfs disk; cd disk; \"$1\" p --defaults >/dev/null; cd p; \
                  cp src/generators/mod.rs ../../before; ls -A src/generators >../../names; \
                  for pages in 0 1 2 3 4 5 6; do \
                    rm -f ../fill; dd if=/dev/zero of=../fill bs=4096 2>/dev/null || true; \
                    truncate -s -$((pages * 4096)) ../fill; \
                    if \"$1\" generator straight_line >../../out 2>&1; then \
                      rm src/generators/straight_line.rs; cp ../../before src/generators/mod.rs; echo made; \
                    else \
                      grep -q 'the disk has no room left' ../../out; \
                      cmp src/generators/mod.rs ../../before; \
                      ls -A src/generators | cmp - ../../names; echo refused; \
                    fi; \
                  done";
    let Some(output) = in_mounts_of_its_own(&folder, script) else { return };
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{said}{errors}{}", folder.read("out"));
    let (refused, made) = (said.matches("refused").count(), said.matches("made").count());
    assert!(refused >= 3 && made >= 1 && refused + made == 7, "{said}");
}
