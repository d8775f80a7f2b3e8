"""A certified controller's theorems for Coq: read what is shipped, write `<p>.v`, ask coqc. The library is proof/."""
