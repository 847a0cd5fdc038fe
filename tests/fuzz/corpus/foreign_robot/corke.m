L(1) = Link('d', 0.67183, 'a', 0, 'alpha', pi/2);
L(2) = Link([0 0 0.4318 0], 'standard');
L(3) = Revolute('d', 0.15005, 'a', 0.0203, 'alpha', -pi/2, 'offset', pi/2);
r = SerialLink(L, 'name', 'puma');
