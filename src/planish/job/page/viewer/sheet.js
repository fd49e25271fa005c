// A column's name sorts by it: numbers the largest first, words from a to z; once more turns round.
const table = document.querySelector('.sheet');
const heads = [...table.tHead.rows[0].cells];
for (const head of heads) {
  const button = head.querySelector('button');
  if (!button) continue;
  button.addEventListener('click', () => {
    const isNumber = head.classList.contains('n');
    const first = isNumber ? 'descending' : 'ascending';
    const second = isNumber ? 'ascending' : 'descending';
    const order = head.getAttribute('aria-sort') === first ? second : first;
    for (const other of heads) other.removeAttribute('aria-sort');
    head.setAttribute('aria-sort', order);
    const sign = order === 'ascending' ? 1 : -1;
    const cell = row => row.cells[head.cellIndex];
    const compare = isNumber
      ? (a, b) => Number(cell(a).dataset.v) - Number(cell(b).dataset.v)
      : (a, b) => cell(a).textContent.localeCompare(cell(b).textContent);
    const body = table.tBodies[0];
    body.append(...[...body.rows].sort((a, b) => sign * compare(a, b)));
  });
}
// As pages say it, once pictures are there.
addEventListener('load', () => { document.documentElement.dataset.ready = 'sheet'; });
