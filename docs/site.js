// SPDX-License-Identifier: LGPL-2.1-or-later
// On every page of the site: what is wider than its page can be scrolled by keys, too. The theme does so for some code.
const reach = box => {
  if (box.scrollWidth > box.clientWidth && box.tabIndex < 0) box.tabIndex = 0;
};
const sizes = new ResizeObserver(entries => entries.forEach(({ target }) => reach(target)));
const attributes = new MutationObserver(changes => changes.forEach(({ target }) => reach(target)));
addEventListener('load', () => {
  for (const box of document.querySelectorAll('.md-typeset__scrollwrap, pre > code')) {
    sizes.observe(box);
    attributes.observe(box, { attributeFilter: ['tabindex'] });
  }
});

// The film on the first page: its track is loaded when it plays first.
const film = document.querySelector('feeling-wind');
film?.querySelector('video').addEventListener('play', () => film.setAttribute('track', 'film/film.klv'), { once: true });
