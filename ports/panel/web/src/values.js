// What is plotted of joints and of readings.
//
// In: a joint as it is measured and demanded, and its limits; the numbers of sensors' readings by their names. Out: curves.

/** A number with one decimal place, and no minus before what is shown as zero. */
export const tenths = (x) => x.toFixed(1).replace(/^-0\.0$/, '0.0');

/** Ways to plot a joint. */
export const SHOWN = {
  position: { of: (measured) => measured },
  /** From -100 % at its lower limit to 100 % at its upper one. */
  share: {
    unit: '% of the range',
    of: (measured, _, { lower, upper }) => (measured === null || lower === null || upper === null ? null : 100 * ((2 * (measured - lower)) / (upper - lower) - 1)),
  },
  error: {
    unit: 'mrad, mm',
    of: (measured, demanded) => (measured === null || demanded === null ? null : 1000 * (measured - demanded)),
  },
};

/** The most curves of one plot. */
const CURVES = 8;

/** Numbers of readings that are plotted together: those of one sensor whose names begin alike, such as `force.x`, `force.y`. */
export function groups(sensors) {
  return sensors.flatMap(({ name, numbers }, sensor) => {
    const found = new Map();
    numbers.forEach((number, place) => {
      const cut = number.search(/(\.[^.]*|\[\d+\])$/), head = cut > 0 ? number.slice(0, cut) : '';
      if (!found.has(head)) found.set(head, []);
      found.get(head).push({ place, name: cut > 0 ? number.slice(cut).replace(/^\./, '') : number });
    });
    return [...found].map(([head, all]) => ({
      title: head ? `${name} ${head}` : name, sensor, places: all.slice(0, CURVES).map(({ place }) => place), names: all.slice(0, CURVES).map(({ name: of }) => of),
    }));
  });
}
