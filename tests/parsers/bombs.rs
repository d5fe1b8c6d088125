//! Input that is made to take much memory and time: it is refused or read within 256 MB.

use mrroc_counting_allocator::peak;

use crate::parsers::targets::TARGETS;
use crate::parsers::{MEMORY, read};

fn target(name: &str) -> crate::parsers::targets::Target {
    TARGETS.iter().find(|(known, _)| *known == name).expect("a reader").1
}

fn reads(name: &str, what: &str, input: &str) {
    let began = std::time::Instant::now();
    let ((), most) = peak(|| read(name, target(name), input.as_bytes()));
    let (seconds, megabytes) = (began.elapsed().as_secs_f64(), most as f64 / 1e6);
    println!("{name:<6}{what:<34}{:>10} bytes: {megabytes:6.1} MB, {seconds:.2} s", input.len());
    assert!(most <= MEMORY, "{name}, {what}: {most} bytes");
}

const SVG: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"9mm\" height=\"9mm\">";

#[test]
fn fault_33_bombs_take_no_more_than_256_megabytes() {
    let million = 1_000_000;
    let nested = |open: &str, close: &str, n: usize| open.repeat(n) + &close.repeat(n);
    // Entities of entities.
    let laughs: String = (1..20).fold("<!DOCTYPE svg [<!ENTITY a0 \"<g/>\">".to_owned(), |text, i| {
        let ten = format!("&a{};", i - 1).repeat(10);
        text + &format!("<!ENTITY a{i} \"{ten}\">")
    });
    reads("svg", "entities of entities", &format!("{laughs}]>{SVG}&a19;</svg>"));
    // Uses of groups of uses.
    let uses: String = (1..40)
        .map(|i| format!("<g id=\"u{i}\">{}</g>", format!("<use xlink:href=\"#u{}\"/>", i - 1).repeat(10)))
        .collect();
    let used = "<use xlink:href=\"#u39\"/></svg>";
    reads("svg", "uses of uses", &format!("{SVG}<defs><path id=\"u0\" d=\"M0 0h1\"/>{uses}</defs>{used}"));
    reads("svg", "nested groups", &format!("{SVG}{}</svg>", nested("<g>", "</g>", 100_000)));
    reads("svg", "a long path", &format!("{SVG}<path d=\"M0 0{}\"/></svg>", "l1 1".repeat(5 * million)));
    reads("svg", "a million lines", &format!("{SVG}{}</svg>", "<path d=\"M0 0h1\"/>".repeat(million)));
    reads("svg", "a long text", &format!("{SVG}<text>{}</text></svg>", "a ".repeat(20 * million)));
    let hidden = "<text visibility=\"hidden\">abc</text>".repeat(million / 2);
    reads("svg", "texts that are not seen", &format!("{SVG}{hidden}</svg>"));
    reads("svg", "an attribute without an end", &format!("{SVG}<path d=\"{}", "0".repeat(60 * million)));

    // As much of both as is allowed, as often as there is room.
    let attributes = |n: usize| (0..n).map(|i| format!(" a{i}=\"\"")).collect::<String>();
    let namespaces = |n: usize| (0..n).map(|i| format!(" xmlns:n{i}=\"u\"")).collect::<String>();
    reads("svg", "many attributes", &format!("{SVG}<g{}/></svg>", attributes(60_000)));
    let element = format!("<g{}/>", attributes(128));
    reads("svg", "a few attributes of many", &format!("{SVG}{}</svg>", element.repeat(million / 128 - 1)));
    reads(
        "svg",
        "more attributes in all",
        &format!("{SVG}{}</svg>", element.repeat(30 * million / element.len())),
    );
    let within: String = (0..240).map(|i| format!("<g{}>", namespaces(50 + i % 2))).collect();
    reads("svg", "namespaces in namespaces", &format!("{SVG}{within}{}</svg>", "</g>".repeat(240)));
    let seeing = format!("<g{}>{}</g>", namespaces(29), "<g xmlns:m=\"u\"/>".repeat(million / 34));
    reads("svg", "some that see namespaces", &format!("{SVG}{seeing}</svg>"));
    let seeing = format!("<g{}>{}</g>", namespaces(29), "<g xmlns:m=\"u\"/>".repeat(900_000));
    reads("svg", "many that see namespaces", &format!("{SVG}{seeing}</svg>"));

    reads("dxf", "one long line", &"1".repeat(60 * million));
    let line = "0\nLINE\n10\n0\n20\n0\n11\n1\n21\n1\n";
    let section = "0\nSECTION\n2\nENTITIES\n";
    reads("dxf", "a million lines", &format!("{section}{}0\nENDSEC\n0\nEOF\n", line.repeat(million)));
    let blocks: String = (1..40)
        .map(|i| {
            format!("0\nBLOCK\n2\nb{i}\n{}0\nENDBLK\n", format!("0\nINSERT\n2\nb{}\n", i - 1).repeat(10))
        })
        .collect();
    let inserts = format!("0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nb0\n{line}0\nENDBLK\n{blocks}0\nENDSEC\n");
    reads("dxf", "blocks of blocks", &format!("{inserts}{section}0\nINSERT\n2\nb39\n0\nENDSEC\n0\nEOF\n"));
    let array = "0\nINSERT\n2\nb0\n70\n32000\n71\n32000\n";
    let text = format!("0\nTEXT\n10\n0\n20\n0\n40\n1\n1\n{}\n", "a".repeat(60_000));
    reads("dxf", "texts without measure", &format!("{section}{}0\nENDSEC\n0\nEOF\n", text.repeat(500)));
    reads("dxf", "an array of a thousand million", &format!("{inserts}{section}{array}0\nENDSEC\n0\nEOF\n"));

    reads("gcode", "one long line", &"G1 X1 ".repeat(10 * million));
    reads("gcode", "nested brackets", &format!("#1={}1{}\n", "[".repeat(30_000), "]".repeat(30_000)));
    reads("gcode", "two million lines", &"G1 X1 Y1\nG1 X2 Y0\n".repeat(million));
    reads("gcode", "a loop without an end", "o1 while [1]\no1 endwhile\n");
    reads("gcode", "a loop that sets and rests", "o1 while [1]\n#1=[#1+1]\nG4 P1\nM[#1]\no1 endwhile\n");
    let loops = |n: usize, inner: &str| {
        let open: String = (0..n).map(|i| format!("o{i} repeat [1000]\n")).collect();
        open + inner + &(0..n).rev().map(|i| format!("o{i} endrepeat\n")).collect::<String>()
    };
    reads("gcode", "loops of loops of moves", &format!("G91 G1\n{}", loops(60, "X1\n")));
    reads("gcode", "a subroutine that calls itself twice", "o1 sub\no1 call\no1 call\no1 endsub\no1 call\n");
    reads("gcode", "a million O-words", &"o1 call\n".repeat(million));
    reads(
        "gcode",
        "openers without ends",
        &(0..million).map(|i| format!("o{i} if [1]\n")).collect::<String>(),
    );
    reads("gcode", "an arc of a million turns", "G2 X0 I1 P1000000\nG2 X0 I1 P10000\n");
    reads("gcode", "pecks of nothing", "G83 X0 Z-1 R1 Q.000000000000001\nG73 X9 Z-1 R1e L1000000 Q1\n");
    reads("gcode", "empty lines", &"\n".repeat(60 * million));

    reads(
        "urdf",
        "entities of entities",
        &format!("{}]><robot name=\"a\">&a19;</robot>", laughs.replace("svg", "robot")),
    );
    reads(
        "urdf",
        "nested elements",
        &format!("<robot name=\"a\">{}</robot>", nested("<a>", "</a>", 100_000)),
    );
    reads(
        "urdf",
        "a million links",
        &format!("<robot name=\"a\">{}</robot>", "<link name=\"a\"/>".repeat(million)),
    );

    let within: String = (0..20_000).map(|i| format!("<a xmlns:n{i}=\"u\">")).collect();
    reads("urdf", "namespaces in namespaces", &format!("<robot name=\"a\">{within}</robot>"));

    reads("cell", "nested arrays", &format!("a = {}", nested("[", "]", 100_000)));
    reads("cell", "nested tables", &format!("[{}a]", "a.".repeat(100_000)));
    reads("cell", "one long line", &format!("step_ms = {}", "1".repeat(20 * million)));
    let robot = |i: usize| format!("[robots.r{i}]\nkind = \"irp6\"\n");
    reads("cell", "ten thousand robots", &(0..10_000).map(robot).collect::<String>());

    reads("trj", "a count of many", "JOINT\n99999999999\nABSOLUTE\n");
    reads("trj", "one long line", &"0.1 ".repeat(10 * million));
    reads(
        "trj",
        "a million poses",
        &format!("JOINT\n1000000\nABSOLUTE\n{}", "1 1\n1 1\n0 0\n".repeat(million)),
    );
}
