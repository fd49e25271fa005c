// Cards of surfaces that were tried: the one that is looked at is kept, and says how it is made.
const cards = [...document.querySelectorAll('.card')];
const keeps = [...document.querySelectorAll('.keep')];

function keep(job) {
  for (const card of cards) {
    if (card.dataset.job === job) card.setAttribute('aria-current', 'true');
    else card.removeAttribute('aria-current');
  }
  for (const section of keeps) section.hidden = section.dataset.keep !== job;
}

// The view is the page's own: its table of surfaces has a link to each.
for (const card of cards) {
  card.addEventListener('click', (event) => {
    event.preventDefault();
    if (document.getElementById('view').hidden) keep(card.dataset.job);
    else document.querySelector(`tr[data-job="${card.dataset.job}"] a`).click();
  });
}
for (const link of document.querySelectorAll('tr[data-job] a'))
  link.addEventListener('click', () => keep(link.closest('tr').dataset.job));

for (const button of document.querySelectorAll('.copy')) {
  button.addEventListener('click', async () => {
    const text = button.parentElement.nextElementSibling;
    getSelection().selectAllChildren(text);
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = 'Copied';
    } catch {
      button.textContent = 'Selected';  // where a page may not copy by itself
    }
  });
}

function follow() {
  const hash = location.hash.slice(1);
  keep(hash.match(/^(?:keep|job)(\d+)$/)?.[1] ?? new URLSearchParams(hash).get('job') ?? '0');
}
addEventListener('hashchange', follow);
follow();
