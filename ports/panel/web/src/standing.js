// What stands in the cell.
//
// In: solids with their poses, as the layout says them. Out: objects of the picture that are seen through, so that arms behind
// them stay in sight.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CylinderGeometry, Group, Mesh, MeshLambertMaterial, Points, PointsMaterial,
  SphereGeometry,
} from 'three';
import { pose6 } from './shown.js';

const COLOUR = '#7d8791';

/** The form of a solid about its frame, its axis along z. */
function form(solid, material) {
  const upright = (geometry) => new Mesh(geometry.rotateX(Math.PI / 2), material);
  const forms = {
    box: ({ edges }) => new Mesh(new BoxGeometry(...edges), material),
    cylinder: ({ radius, length }) => upright(new CylinderGeometry(radius, radius, length, 36)),
    capsule: ({ radius, length }) => upright(new CapsuleGeometry(radius, length, 10, 28)),
    ball: ({ radius }) => new Mesh(new SphereGeometry(radius, 28, 18), material),
    points: ({ points, radius }) => {
      const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
      return new Points(geometry, new PointsMaterial({ color: COLOUR, size: 2 * radius }));
    },
  };
  return forms[solid.form]?.(solid) ?? new Group();
}

/** All that stands in a cell, as one object. */
export function standing(obstacles) {
  const group = new Group();
  const material = new MeshLambertMaterial({ color: COLOUR, transparent: true, opacity: 0.4, depthWrite: false });
  for (const obstacle of obstacles) {
    const shown = form(obstacle, material);
    shown.name = obstacle.name;
    pose6(shown, obstacle.pose);
    group.add(shown);
  }
  return group;
}

/** Frees what a picture no longer shows. */
export function clear(group) {
  group.children.forEach(({ geometry, material }) => {
    geometry?.dispose();
    material?.dispose();
  });
}
