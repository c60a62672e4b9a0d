(() => {
const all = (what, where = document) => [...where.querySelectorAll(what)];
const make = (name, attributes, text) => {
  const element = document.createElement(name);
  Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
  if (text) element.textContent = text;
  return element;
};

// Tables: sorting by a click on a heading, filtering by words and verdicts.
const value = (row, column) => {
  const text = (row.cells[column]?.firstChild?.textContent ?? '').trim();
  const number = text.replace(/\u2212/g, '-').replace(/[\u00a0\u202f]/g, '').match(/^-?[\d.]+(e-?\d+)?/);
  return number ? [0, parseFloat(number[0])] : [text && text !== '\u2013' ? 1 : 2, text.toLowerCase()];
};
const order = (a, b) => a[0] - b[0] || (a[1] < b[1] ? -1 : a[1] > b[1] ? 1 : 0);
for (const table of all('.table table')) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[table.tHead.rows.length - 1].cells];
  if (!body || body.rows.length < 4) continue;
  heads.forEach((head, column) => {
    if (head.tagName !== 'TH') return;
    const button = make('button', { type: 'button' }, head.textContent);
    head.replaceChildren(button);
    button.onclick = () => {
      const up = head.getAttribute('aria-sort') !== 'ascending';
      heads.forEach(other => other.removeAttribute('aria-sort'));
      head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
      const rows = [...body.rows].map(row => [value(row, column), row]);
      rows.sort((a, b) => (up ? 1 : -1) * order(a[0], b[0]) || 0).forEach(([, row]) => body.append(row));
    };
  });
}
for (const place of all('.table.filter')) {
  const rows = [...place.querySelector('tbody').rows], find = make('div', { class: 'find' });
  const input = make('input', { type: 'search', 'aria-label': 'Filter the rows of the table', placeholder: 'filter rows' });
  const count = make('span', { class: 'soft', role: 'status' });
  const words = [...new Set(rows.flatMap(row => all('.badge', row).map(b => b.textContent)))].slice(0, 6);
  let wanted = '';
  const show = () => {
    const parts = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      const fits = parts.every(part => text.includes(part)) && (!wanted || all('.badge', row).some(b => b.textContent === wanted));
      row.hidden = !fits;
      shown += fits;
    }
    count.textContent = `${shown} of ${rows.length} rows`;
  };
  input.oninput = show;
  find.append(input);
  if (words.length > 1) {
    const buttons = words.map(word => make('button', { type: 'button', 'aria-pressed': 'false' }, word));
    buttons.forEach(button => {
      button.onclick = () => {
        wanted = wanted === button.textContent ? '' : button.textContent;
        buttons.forEach(b => b.setAttribute('aria-pressed', b.textContent === wanted));
        show();
      };
    });
    find.append(...buttons);
  }
  find.append(count);
  place.prepend(find);
  show();
}

// Where a table does not fit beside the list of pages, that goes below.
const wide = matchMedia('(min-width: 1180px)'), frame = all('.frame')[0];
const place = () => {
  frame.classList.remove('wide');
  frame.classList.toggle('wide', wide.matches && all('.box').some(box => box.scrollWidth > box.clientWidth + 1));
};
wide.onchange = place;
place();

// Figures: series on and off by the legend, values under the pointer.
const along = (axis, v) => {
  const f = axis.l ? Math.log10 : x => x;
  return (f(v) - f(axis.a)) / (f(axis.b) - f(axis.a));
};
const shown = v => (Math.abs(v) >= 1e-3 && Math.abs(v) < 1e5) || v === 0 ? String(+v.toPrecision(5)) : v.toExponential(3);
const told = (axis, v) => {
  const known = axis.t.find(([place]) => place === v), name = axis.n.replace(/ \((.*)\)$/, ''), unit = axis.n.match(/ \(([^()]*)\)$/);
  if (known) return name ? `${name}: ${known[1]}` : known[1];
  return `${name || 'value'} = ${shown(v)}${unit && !/^[-\u2013]$/.test(unit[1]) ? ' ' + unit[1] : ''}`;
};
for (const figure of all('figure.plot')) {
  const picture = figure.querySelector('.picture'), svg = picture.querySelector('svg');
  const off = new Set(), legend = all('[data-l]', svg);
  const panels = JSON.parse(figure.querySelector('script').textContent);
  for (const entry of legend) {
    const name = entry.getAttribute('aria-label');
    const turn = () => {
      const hide = !off.delete(name);
      if (hide) off.add(name);
      entry.setAttribute('aria-pressed', !hide);
      all(`[data-s="${entry.dataset.l}"]`, svg).forEach(series => series.classList.toggle('off', hide));
    };
    entry.onclick = turn;
    entry.onkeydown = event => {
      if (event.key === ' ' || event.key === 'Enter') { event.preventDefault(); turn(); }
    };
  }
  let tip, spot;
  const away = () => { tip?.remove(); spot?.remove(); tip = spot = undefined; };
  svg.addEventListener('pointerleave', away);
  svg.addEventListener('pointermove', event => {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
    let best, least = (28 * scale) ** 2;
    for (const p of panels) {
      const [left, top, right, bottom] = p.f;
      if (x < left - 40 || x > right + 40 || y < top - 40 || y > bottom + 40) continue;
      for (const s of p.s) {
        if ([...off].some(name => s.n === name || s.n.endsWith(`, ${name}`))) continue;
        for (let k = 0; k < s.p.length; k += 2) {
          const px = left + along(p.x, s.p[k]) * (right - left), py = bottom - along(p.y, s.p[k + 1]) * (bottom - top);
          if (px < left - 9 || px > right + 9 || py < top - 9 || py > bottom + 9) continue;
          const far = (px - x) ** 2 + (py - y) ** 2;
          if (far < least) { least = far; best = { p, s, k, px, py }; }
        }
      }
    }
    away();
    if (!best) return;
    const { p, s, k, px, py } = best, from = s.o[k / 2] || 0;
    tip = make('div', { class: 'tip', role: 'status' }, `${s.n}\n${told(p.x, s.p[k])}\n${told(p.y, s.p[k + 1] - from)}`);
    spot = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
    Object.entries({ cx: px, cy: py, r: 26, class: 'spot' }).forEach(([key, v]) => spot.setAttribute(key, v));
    svg.append(spot);
    picture.append(tip);
    const inner = picture.getBoundingClientRect(), at = box.left - inner.left + picture.scrollLeft + px / scale;
    const turned = at - picture.scrollLeft > inner.width / 2;
    tip.style.left = `${turned ? at - tip.offsetWidth - 14 : at + 14}px`;
    tip.style.top = `${Math.max(2, box.top - inner.top + py / scale - tip.offsetHeight - 4)}px`;
  });
}

// Folded sections open when a link leads into them, and for printing.
const unfold = () => {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  all('details', target).slice(0, 1).concat(target.closest('details') ?? []).forEach(d => { d.open = true; });
};
addEventListener('hashchange', unfold);
unfold();
addEventListener('beforeprint', () => all('details').forEach(d => { d.open = true; }));
})();
