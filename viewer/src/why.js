// Why this contact: what it cost, and what else there was and by what it was refused.
import { el } from './dom.js';
import { describeChange } from './data.js';
import { term } from './terms.js';
import { BARRIERS } from './tree.js';
import { count } from './units.js';

/** The choice that led to a stance, as a section of the panel; nothing where none is known. */
export function choiceSection(trace, stance, stances) {
  const made = trace?.choices.find((choice) => choice.stance === stance.index);
  const stuck = stance.index === stances - 1 && trace?.choices.find((choice) => choice.stance === stances);
  return [made && section('Why this contact', made), stuck && section('What was tried from here', stuck)].filter(Boolean);
}

function section(title, { price, alternatives, more }) {
  const cost = price === undefined ? [] : [el('p', { class: 'note' }, term('Price'), ` ${price.toFixed(1)}; what else there was:`)];
  const rest = more ? [el('p', { class: 'note' }, `and ${count(more)} more, dearer`)] : [];
  const table = el('table', { class: 'why-table' },
    el('thead', {}, el('tr', {}, ['change', 'price', ''].map((name) => el('th', { scope: 'col' }, name || el('span', { class: 'unseen-text' }, 'what became of it'))))),
    el('tbody', {}, alternatives.map((one) => el('tr', {},
      el('th', { scope: 'row' }, describeChange(one.change)),
      el('td', { class: 'number' }, one.price.toFixed(1)),
      el('td', {}, one.by && el('span', { class: `barrier ${BARRIERS[one.by].name}` }, BARRIERS[one.by].says), el('small', {}, one.reason))))));
  return el('section', {}, el('h3', {}, title), cost,
    alternatives.length ? table : el('p', { class: 'note' }, 'There was nothing else.'), rest);
}
