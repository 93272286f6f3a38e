// The words of the field, explained by a tap.
import { el } from './dom.js';

const MEANINGS = {
  'Friction used, of μ': 'The sideways part of a contact force over the largest that friction holds there. At 100 % the contact slips.',
  'Torque used, of limit': 'The largest part of its limit that any joint has to exert.',
  'Joint range left': 'How far the joint nearest to an end of its range is from it.',
  'Clearance to scene': 'The least distance between the robot and what it does not mean to touch.',
  'Clearance to itself': 'The least distance between two links that could hit each other.',
  'Patch inside surface': 'How far the patch stays inside what is surely there of the face it touches.',
  'CoM inside support': 'How far the centre of mass (CoM) is inside the region over which the contacts can balance the weight.',
  'Contact closure': 'How far patches are from lying in the faces that they touch: an error of the solution.',
  'Equilibrium, of weight': 'What is left of forces and moments that should cancel, as a part of the weight: an error of the solution.',
  'Nodes generated': 'Contact sets for which a posture of the whole body was found.',
  'Nodes expanded': 'Contact sets from which changes of one contact were tried.',
  'Posture problems solved': 'How often a posture was sought, found or not.',
  'Contact sets on the path': 'The sets of contacts that the plan goes through, one change after the other.',
  Price: 'Contacts made so far and still to be made, as estimated, with what odd places and earlier failures are charged: the search takes the cheapest first.',
  Seed: 'The number that all that is random begins with: the same seed gives the same plan.',
  'Support region, from above': 'Where the centre of mass may be for the contacts to balance the weight.',
  'inset mm': 'How much is taken off at the edges of a face, because they are not known better.',
  'RMS mm': 'How far the measured points are from the plane of the face, root mean square.',
  tilt: 'The angle between the face and the level.',
  normal: 'The part of the contact force that presses onto the face.',
  friction: 'The part of the friction that the contact uses, and the coefficient μ.',
};

let explained = null;

/** A word; where it needs one, with an explanation that opens by a tap or by Enter. */
export function term(word) {
  const meaning = MEANINGS[word];
  if (!meaning) return word;
  return el('button', { type: 'button', class: 'term', onclick: () => explain(word, meaning) }, word);
}

function explain(word, meaning) {
  explained ??= document.body.appendChild(el('div', { class: 'explained', popover: 'auto', role: 'note' }));
  explained.replaceChildren(el('b', {}, word), el('p', {}, meaning));
  explained.showPopover();
}
