// Tables that are wider than the window can be scrolled by key. The theme puts them into boxes when it starts.
const reach = () =>
  document.querySelectorAll(".md-typeset__scrollwrap:not([tabindex])").forEach((box) => {
    box.tabIndex = 0;
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", "table");
  });
new MutationObserver(reach).observe(document.body, { childList: true, subtree: true });
reach();
