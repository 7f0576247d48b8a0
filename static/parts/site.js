// In the head of each page of a static site, before anything is painted: does what a server does with a request.
{
  const root = document.documentElement;
  const { pathname, search, hash } = window.location;
  const query = new URLSearchParams(search);
  const cookies = new Map(document.cookie.split("; ").map((each) => each.split("=")));
  const [english, ...others] = (root.dataset.languages ?? "").split(" ");

  // The English pages are in the folder of the site, those of other languages in folders below it.
  const liked = root.lang === english ? navigator.languages.map((tag) => tag.slice(0, 2).toLowerCase()) : [];
  const asked = [query.get("language"), cookies.get("language"), ...liked];
  const language = asked.find((name) => name === english || others.includes(name)) ?? root.lang;
  if (language !== root.lang) {
    query.delete("language");
    const up = root.lang === english ? "./" : "../";
    const page = pathname.slice(pathname.lastIndexOf("/") + 1);
    const folder = language === english ? "" : `${language}/`;
    window.location.replace(`${up}${folder}${page}${query.size ? `?${query}` : ""}${hash}`);
  }
  const scheme = cookies.get("scheme");
  if (scheme === "light" || scheme === "dark") root.dataset.scheme = scheme;
  for (const view of ["compare", "embed"]) if (root.dataset.mode === "replay" && query.has(view)) root.dataset.view = view;
}
