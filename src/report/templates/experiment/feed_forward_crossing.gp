way = "way (0: source's time; 1: nominal T; 2: consumption)"
@canvas 900,630
set multiplot layout 2,1 title 'Clocks 50 ppm apart, no jitter: a crossing at 1.5 s' @heading
do for [shown in 'velocity jerk'] {
  @panel
  set title shown eq 'jerk' ? 'Jerk' : 'Velocity INT reconstructs'
  set xlabel 't [s]'
  set ylabel shown eq 'jerk' ? 'jerk of joint 1 / its limit' : 'dq_d of joint 1 [rad/s]'
  y = shown eq 'jerk' ? 'jerk / limit' : 'dq_d [rad/s]'
  plot $data using (of(way, 2, "t [s]")):(column(y)) @line lc rgb RS title shown eq 'jerk' ? '' : 'where consumed', \
    '' using (of(way, 0, "t [s]")):(column(y)) @line lc rgb series(4) title shown eq 'jerk' ? '' : 'over the source''s elapsed time', \
    '' using (of(way, 1, "t [s]")):(column(y)) @dashed lc rgb RA title shown eq 'jerk' ? '' : 'over the nominal T'
}
