// Where the tool of an arm is, by its URDF: the test of where a page shows it.

const numbers = (text) => text.trim().split(/\s+/).map(Number);

/** Multiplies two 4 x 4 matrices, rows first. */
export function multiply(a, b) {
  return a.map((row) => b[0].map((_, j) => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
}

function turn([x, y, z], angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)], v = 1 - c;
  return [
    [c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0],
    [y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0],
    [z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0],
    [0, 0, 0, 1],
  ];
}

export function shift([x, y, z]) {
  return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]];
}

function origin(body, tag) {
  const element = body.match(new RegExp(`<${tag}[^>]*>`))?.[0] ?? '';
  const attribute = (name) => numbers(element.match(new RegExp(`${name}="([^"]*)"`))?.[1] ?? '0 0 0');
  const [roll, pitch, yaw] = attribute('rpy');
  const turned = multiply(multiply(turn([0, 0, 1], yaw), turn([0, 1, 0], pitch)), turn([1, 0, 0], roll));
  return multiply(shift(attribute('xyz')), turned);
}

/** The poses of the links of a serial arm in its base at these joints, by the text of its URDF; and where a link's shape stands in it. */
export function linkPoses(urdf, joints) {
  const poses = new Map();
  let at = 0;
  for (const [, kind, body] of urdf.matchAll(/<joint name="[^"]*" type="([a-z]+)">([\s\S]*?)<\/joint>/g)) {
    const link = (role) => body.match(new RegExp(`<${role} link="([^"]*)"`))[1];
    if (!poses.size) poses.set(link('parent'), shift([0, 0, 0]));
    let pose = multiply(poses.get(link('parent')), origin(body, 'origin'));
    if (kind === 'revolute') pose = multiply(pose, turn(numbers(body.match(/<axis xyz="([^"]*)"/)[1]), joints[at++]));
    else if (kind !== 'fixed') throw new Error(`a joint of type ${kind}`);
    poses.set(link('child'), pose);
  }
  if (at !== joints.length) throw new Error(`${at} joints in the URDF, ${joints.length} in the cell`);
  const visual = (name) => origin(urdf.match(new RegExp(`<link name="${name}">[\\s\\S]*?<visual>([\\s\\S]*?)</visual>`))[1], 'origin');
  return { get: (name) => poses.get(name), visual };
}

/** The pose of the last link of a serial arm at these joints, by the text of its URDF. */
export function lastLink(urdf, joints) {
  let pose = shift([0, 0, 0]), at = 0;
  for (const [, kind, body] of urdf.matchAll(/<joint name="[^"]*" type="([a-z]+)">([\s\S]*?)<\/joint>/g)) {
    const attribute = (tag, name) => numbers(body.match(new RegExp(`<${tag}[^>]*${name}="([^"]*)"`))?.[1] ?? '0 0 0');
    const [roll, pitch, yaw] = attribute('origin', 'rpy');
    const turned = multiply(multiply(turn([0, 0, 1], yaw), turn([0, 1, 0], pitch)), turn([1, 0, 0], roll));
    pose = multiply(multiply(pose, shift(attribute('origin', 'xyz'))), turned);
    if (kind === 'revolute' || kind === 'continuous') pose = multiply(pose, turn(attribute('axis', 'xyz'), joints[at++]));
    else if (kind !== 'fixed') throw new Error(`a joint of type ${kind}`);
  }
  if (at !== joints.length) throw new Error(`${at} joints in the URDF, ${joints.length} in the cell`);
  return pose;
}
