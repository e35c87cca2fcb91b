way = "way (0: source's time; 1: nominal T; 2: consumption)"
at(jitter, i) = column("jitter [s]") == jitter && column(way) == i ? column("drift [ppm]") : NaN
@canvas 900,630
set multiplot layout 2,1 title 'Canonical trajectory through the reference generator' @heading
do for [i = 1:2] {
  jitter = i == 1 ? 4e-6 : 0
  @panel
  set title jitter == 0 ? 'No jitter' : 'Jitter of 4 us'
  set xlabel 'drift between the two loops [ppm]'
  set ylabel 'largest jerk / its limit'
  set logscale y
  plot $data using (at(jitter, 0)):4 @line lc rgb series(4) title 'over the source''s elapsed time', \
    '' using (at(jitter, 1)):4 @dashed lc rgb RA title 'over the nominal T', \
    '' using (at(jitter, 2)):4 @line lc rgb RS title 'where consumed', \
    1 @dashed lc rgb LIMIT title 'limit'
}
