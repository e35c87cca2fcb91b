@canvas 900,930
set multiplot layout 3,1 title 'Commanded velocity of joint 1' @heading
@panel
set title 'the whole motion'
set xlabel 't [s]'
set ylabel 'dq_c [rad/s]'
plot $data using 1:"off [rad/s]" @steps lc rgb RS title 'off', '' using 1:"on [rad/s]" @steps lc rgb LF title 'on'
@panel
set title '80 ms of it'
set xlabel 't [s]'
set ylabel 'dq_c [rad/s]'
set xrange [0.6:0.68]
plot $data using 1:"off [rad/s]" @steps lc rgb RS title 'off', '' using 1:"on [rad/s]" @steps lc rgb LF title 'on'
@panel
set title 'increment of each cycle'
set xlabel 't [s]'
set ylabel 'increment [rad/s]'
set xrange [0.6:0.68]
plot $data using 1:"increment off [rad/s]" @steps lc rgb RS title 'off', \
  '' using 1:"increment on [rad/s]" @steps lc rgb LF title 'on'
