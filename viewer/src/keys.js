// The keyboard: arrows choose the stance, Shift and arrows move the camera.
import { VIEWS } from './camera.js';

/** What keys are written into. */
const WRITES = 'textarea, select, input:not([type=range], [type=checkbox])';
const TURN_RAD = Math.PI / 24;

/** Keys act unless the focused element uses them itself. */
export function listenToKeys({ transport, viewpoint, toggleTheme }) {
  const plain = {
    ArrowLeft: () => transport.step(-1),
    ArrowRight: () => transport.step(1),
    Home: () => transport.step(-transport.count),
    End: () => transport.step(transport.count),
    ' ': () => transport.toggle(),
    f: () => transport.toggleFollow(),
  };
  const always = {
    t: toggleTheme,
    '+': () => viewpoint.zoom(0.9),
    '=': () => viewpoint.zoom(0.9),
    '-': () => viewpoint.zoom(1 / 0.9),
    ...Object.fromEntries(VIEWS.map(({ name }, i) => [String(i + 1), () => viewpoint.go(name)])),
  };
  const turned = {
    ArrowLeft: () => viewpoint.orbit(-TURN_RAD, 0),
    ArrowRight: () => viewpoint.orbit(TURN_RAD, 0),
    ArrowUp: () => viewpoint.orbit(0, TURN_RAD),
    ArrowDown: () => viewpoint.orbit(0, -TURN_RAD),
  };
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches(WRITES)) return;
    const own = ownKeys(event.target);
    const action = event.shiftKey && turned[event.key]
      ? turned[event.key]
      : always[event.key] ?? (transport.count && !own.includes(event.key) ? plain[event.key] : undefined);
    if (!action) return;
    event.preventDefault();
    action();
  });
}

/** The keys that an element answers by itself. */
function ownKeys(target) {
  if (target.matches('input[type=range]')) return ['ArrowLeft', 'ArrowRight', 'Home', 'End'];
  if (target.matches('button, summary, input[type=checkbox]')) return [' '];
  return [];
}
